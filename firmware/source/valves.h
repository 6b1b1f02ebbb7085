// Runs a table of changes: two valves for each actuator.
#pragma once
#include <stdint.h>

#define VALVE_TICK_US 100

void valves_start(void);
void valves_make_safe(void);
// One tick of the clock; gives the time to the next, in its counts.
uint16_t valves_step(void);
uint32_t valves_phase_us(void);
