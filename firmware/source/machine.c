#include "machine.h"
#include "pins.h"
#include "program.h"
#include "servos.h"
#include "valves.h"

#include <util/atomic.h>

// A stop circuit that is open this long is open: shorter than any button, longer than sparks of a valve.
#define STOP_OPEN_US 1000

struct machine machine = {.timeout_us = DEFAULT_TIMEOUT_MS * 1000UL};

void machine_start(const struct start *start) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        machine.cycle = 0;
        machine.cycles = start->cycles;
        machine.timeout_us = start->timeout_ms * 1000UL;
        if (program.settings.kind == VALVES) valves_start();
        else servos_start();
        machine.state = RUNNING;
    }
}

void machine_leave(uint8_t state) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        if (machine.state == RUNNING) {
            if (program.settings.kind == VALVES) valves_make_safe();
            else servos_make_safe();
        }
        machine.state = state;
    }
}

void machine_estop(uint8_t fault) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        machine_leave(ESTOPPED);
        machine.faults |= fault;
    }
}

bool machine_count_cycle(void) {
    machine.cycle++;
    if (machine.cycles == 0 || machine.cycle < machine.cycles) return true;
    machine_leave(ARMED);
    machine.event = DONE;
    return false;
}

void machine_tick(uint16_t us) {
    static uint16_t open_us;
    if (!pins_stop_open()) open_us = 0;
    else if (open_us < STOP_OPEN_US) open_us += us;
    else if (!(machine.faults & FAULT_STOP_PIN)) {
        machine_estop(FAULT_STOP_PIN);
        machine.event = STOP_PRESSED;
    }
    if (machine.silence_us < MOST_PERIOD_US) machine.silence_us += us;
    if (machine.state == RUNNING && machine.silence_us >= machine.timeout_us) {
        machine_leave(FAULT);
        machine.faults |= FAULT_LINK;
        machine.event = LINK_LOST;
    }
}
