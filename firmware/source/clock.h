// The one clock: timer 1, whose interrupt runs the schedule and counts all times.
#pragma once
#include <stdbool.h>
#include <stdint.h>

#define COUNTS_PER_US 2

void clock_init(void);
// Spins through the last microseconds, so that the latency of the interrupt is not seen at the pins.
void clock_wait_until_due(void);
// Whether the clock has run since the last call.
bool clock_has_ticked(void);
// Milliseconds since the reset, for the lamp.
uint16_t clock_ms(void);
