// What the board is to do: settings, channels and a table, as the host has loaded them.
#pragma once
#include "protocol.h"

#include <stdbool.h>

struct program {
    struct settings settings;
    struct channel channels[MAX_CHANNELS];
    union {
        uint8_t bytes[TABLE_BYTES];
        struct change changes[TABLE_BYTES / sizeof(struct change)];
        uint16_t pulses[TABLE_BYTES / 2]; // channel by channel
    } table;
};

extern struct program program;

// Each gives 0 or an error; the last one tells the row that is wrong.
uint8_t program_configure(const struct settings *settings);
uint8_t program_set_channel(const struct channel_message *message);
uint8_t program_load(const struct load *load, uint8_t length);
uint8_t program_check(uint32_t crc, uint16_t *detail);
// Forgets all.
void program_clear(void);
