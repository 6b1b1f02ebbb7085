#include "servos.h"
#include "clock.h"
#include "machine.h"
#include "pins.h"
#include "program.h"

// Eight slots make a frame of 20 ms. A slot without a servo passes without a pulse.
#define SLOT_US 2500
#define SLOT_COUNTS (SLOT_US * COUNTS_PER_US)
#define EMPTY_COUNTS (1000 * COUNTS_PER_US)

struct pulse {
    struct pin_set pin;
    uint16_t counts;
};

static const struct pulse NO_PULSE = {{0, 0, 0}, EMPTY_COUNTS};
static struct pulse current = {{0, 0, 0}, EMPTY_COUNTS};
static struct pulse upcoming = {{0, 0, 0}, EMPTY_COUNTS};
static uint8_t slot; // of the current pulse
static bool high;    // the current pulse is under way
static bool resting; // pulses of rest, as the safe state says
static bool begun;

// Where the curves are: `row` and, between it and the next, `part` of the period (a row takes period / rows,
// which is no whole number, so that time is counted in 1 / rows of a microsecond, exactly).
static uint16_t row;
static uint32_t part;
static uint32_t phase_us;

void servos_start(void) {
    begun = false;
    resting = false;
}

void servos_make_safe(void) {
    resting = program.settings.safe == REST;
    // A pulse that is under way ends as it should; one that is only computed does not come.
    upcoming = NO_PULSE;
}

void servos_release(void) {
    resting = false;
    upcoming = NO_PULSE;
}

uint16_t servos_step(void) {
    clock_wait_until_due();
    if (high) {
        pins_lower(&current.pin);
        high = false;
        return SLOT_COUNTS - current.counts;
    }
    pins_raise(&upcoming.pin); // at once, as it is lowered above: what comes between would shorten the pulse
    current = upcoming;
    slot = (slot + 1) & 7;
    high = true;
    return current.counts;
}

// False at the end of the last cycle.
static bool advance(void) {
    const struct settings *s = &program.settings;
    if (!begun) {
        begun = true;
        row = 0;
        part = 0;
        phase_us = 0;
        return true;
    }
    for (part += (uint32_t)SLOT_US * s->rows; part >= s->period_us; part -= s->period_us) {
        if (++row == s->rows) row = 0;
    }
    phase_us += SLOT_US;
    if (phase_us < s->period_us) return true;
    phase_us -= s->period_us;
    return machine_count_cycle();
}

static uint16_t curve(uint8_t channel) {
    const struct settings *s = &program.settings;
    const uint16_t *pulses = &program.table.pulses[channel * s->rows];
    uint16_t from = pulses[row] * COUNTS_PER_US;
    uint16_t to = pulses[row + 1 == s->rows ? 0 : row + 1] * COUNTS_PER_US;
    // Sixteen bits of both: what is lost is less than a count, and 32 bits suffice for the product.
    uint32_t whole = s->period_us, done = part;
    while (whole > 0xFFFF) {
        whole >>= 1;
        done >>= 1;
    }
    if (to >= from) return from + (to - from) * done / whole;
    return from - (from - to) * done / whole;
}

void servos_prepare(void) {
    if (!high) return;
    bool running = machine.state == RUNNING;
    upcoming = NO_PULSE;
    if (running && !advance()) return;
    uint8_t channel = (slot + 1) & 7;
    if (channel >= program.settings.channels || !(running || resting)) return;
    upcoming.counts = running ? curve(channel) : program.channels[channel].rest_us * COUNTS_PER_US;
    pins_add(&upcoming.pin, program.channels[channel].pin);
}

uint32_t servos_phase_us(void) {
    return phase_us;
}
