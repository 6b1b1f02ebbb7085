#include "valves.h"
#include "clock.h"
#include "machine.h"
#include "pins.h"
#include "program.h"

static uint32_t phase_us;
static uint16_t next; // row of the table

static void open_valves(uint8_t inflate, uint8_t vent) {
    struct pin_set high = {0, 0, 0};
    for (uint8_t i = 0; i < program.settings.channels; i++, inflate >>= 1, vent >>= 1) {
        // Whatever a table says: never both of one actuator.
        if (inflate & 1) pins_add(&high, program.channels[i].pin);
        else if (vent & 1) pins_add(&high, program.channels[i].vent_pin);
    }
    pins_write(&high);
}

void valves_start(void) {
    // The first tick begins the period.
    phase_us = -(uint32_t)VALVE_TICK_US;
    next = 0;
}

void valves_make_safe(void) {
    open_valves(0, program.settings.safe == VENT ? 0xFF : 0);
}

uint16_t valves_step(void) {
    if (machine.state == RUNNING) {
        phase_us += VALVE_TICK_US;
        // The rest of a tick is carried into the next period: nothing is lost in years.
        if (phase_us >= program.settings.period_us) {
            phase_us -= program.settings.period_us;
            next = 0;
            if (!machine_count_cycle()) return VALVE_TICK_US * COUNTS_PER_US;
        }
        const struct change *due = 0;
        while (next < program.settings.rows && program.table.changes[next].at_us <= phase_us) {
            due = &program.table.changes[next++];
        }
        if (due) open_valves(due->inflate, due->vent);
    }
    return VALVE_TICK_US * COUNTS_PER_US;
}

uint32_t valves_phase_us(void) {
    // Before the first tick it is behind zero.
    return phase_us < program.settings.period_us ? phase_us : 0;
}
