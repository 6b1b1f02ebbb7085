// The state of the board, and what brings it to a stop.
#pragma once
#include "protocol.h"

#include <stdbool.h>

struct machine {
    volatile uint8_t state;
    volatile uint8_t faults;
    volatile uint8_t event; // to be told to the host, or 0
    volatile uint32_t cycle;
    volatile uint32_t silence_us; // since the last valid frame of the session
    uint32_t cycles;              // to run, or 0
    uint32_t timeout_us;
};

extern struct machine machine;

void machine_start(const struct start *start);
// Outputs change only while RUNNING and here, at its end: to the safe state.
void machine_leave(uint8_t state);
void machine_estop(uint8_t fault);
// A turn of the schedule is complete; false if it was the last.
bool machine_count_cycle(void);
// Called by the clock, in its interrupt, with the time since the last call.
void machine_tick(uint16_t us);
