#include "program.h"
#include "crc.h"
#include "pins.h"

#include <string.h>

struct program program;
static uint8_t channels_set; // bit n: channel n has come
static uint32_t pins_taken;

void program_clear(void) {
    memset(&program.settings, 0, sizeof program.settings);
    channels_set = 0;
    pins_taken = 0;
}

static uint16_t table_length(const struct settings *s) {
    if (s->kind == VALVES) return s->rows * sizeof(struct change);
    return s->rows * s->channels * sizeof(uint16_t);
}

uint8_t program_configure(const struct settings *s) {
    program_clear();
    bool valves = s->kind == VALVES && s->safe <= VENT;
    bool servos = s->kind == SERVOS && (s->safe == RELEASE || s->safe == REST);
    if (!valves && !servos) return OUT_OF_LIMITS;
    if (s->channels == 0 || s->channels > MAX_CHANNELS) return OUT_OF_LIMITS;
    // Rows first: their product with what a row takes must not overflow.
    if (s->rows == 0 || s->rows > TABLE_BYTES || table_length(s) > TABLE_BYTES) return OUT_OF_LIMITS;
    if (s->period_us < LEAST_PERIOD_US || s->period_us > MOST_PERIOD_US) return OUT_OF_LIMITS;
    program.settings = *s;
    return 0;
}

static bool take(uint8_t pin) {
    if (!pins_is_output(pin)) return false;
    uint32_t bit = 1UL << pin;
    if (pins_taken & bit) return false;
    pins_taken |= bit;
    return true;
}

uint8_t program_set_channel(const struct channel_message *m) {
    if (program.settings.kind == NOTHING) return NOTHING_LOADED;
    // In order, each once: a pin that is taken is then taken by another channel.
    uint8_t next = 0;
    while (channels_set >> next & 1) next++;
    if (m->index != next || m->index >= program.settings.channels) return OUT_OF_LIMITS;
    const struct channel *c = &m->channel;
    if (program.settings.kind == SERVOS) {
        bool inside = c->least_us >= LEAST_PULSE_US && c->least_us <= c->rest_us;
        if (!inside || c->rest_us > c->most_us || c->most_us > MOST_PULSE_US) return OUT_OF_LIMITS;
    }
    if (!take(c->pin)) return BAD_PIN;
    if (program.settings.kind == VALVES && !take(c->vent_pin)) return BAD_PIN;
    program.channels[m->index] = *c;
    channels_set |= 1 << m->index;
    return 0;
}

uint8_t program_load(const struct load *load, uint8_t length) {
    if (program.settings.kind == NOTHING) return NOTHING_LOADED;
    uint16_t end = table_length(&program.settings);
    if (load->offset > end || length > end - load->offset) return OUT_OF_LIMITS;
    memcpy(program.table.bytes + load->offset, load->bytes, length);
    return 0;
}

static bool changes_are_sound(uint16_t *row) {
    const struct settings *s = &program.settings;
    uint8_t others = ~((1 << s->channels) - 1);
    for (*row = 0; *row < s->rows; ++*row) {
        const struct change *c = &program.table.changes[*row];
        bool in_order = *row == 0 ? c->at_us == 0 : c->at_us > c[-1].at_us;
        if (!in_order || c->at_us >= s->period_us) return false;
        if (c->inflate & c->vent || (c->inflate | c->vent) & others) return false;
    }
    return true;
}

static bool pulses_are_sound(uint16_t *row) {
    const struct settings *s = &program.settings;
    *row = 0;
    for (uint8_t i = 0; i < s->channels; i++) {
        for (uint16_t k = 0; k < s->rows; k++, ++*row) {
            uint16_t pulse = program.table.pulses[*row];
            if (pulse < program.channels[i].least_us || pulse > program.channels[i].most_us) return false;
        }
    }
    return true;
}

uint8_t program_check(uint32_t expected, uint16_t *detail) {
    const struct settings *s = &program.settings;
    if (s->kind == NOTHING || channels_set != (uint8_t)((1 << s->channels) - 1)) return NOTHING_LOADED;
    uint32_t crc = crc_more(CRC_BEGIN, s, sizeof *s);
    crc = crc_more(crc, program.channels, s->channels * sizeof(struct channel));
    crc = crc_more(crc, program.table.bytes, table_length(s));
    if (~crc != expected) return OTHER_TABLE;
    bool sound = s->kind == VALVES ? changes_are_sound(detail) : pulses_are_sound(detail);
    return sound ? 0 : BAD_TABLE;
}
