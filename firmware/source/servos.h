// Runs curves of pulse lengths: one servo for each channel, one after the other within a frame of 20 ms.
#pragma once
#include <stdint.h>

void servos_start(void);
void servos_make_safe(void);
// Begins or ends a pulse; gives the time to the next call, in counts of the clock.
uint16_t servos_step(void);
// Computes the next pulse, while the present one lasts.
void servos_prepare(void);
// No pulses any more.
void servos_release(void);
uint32_t servos_phase_us(void);
