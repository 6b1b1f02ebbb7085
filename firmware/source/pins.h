// Outputs by their Arduino numbers: 0 to 13 are D0 to D13, 14 to 19 are A0 to A5.
#pragma once
#include <stdbool.h>
#include <stdint.h>

// D3 to D12 and A0 to A5: sixteen. D0 and D1 are the serial line, D2 the stop circuit. D13 is the lamp, as
// the boot loader blinks it at each reset, and a valve there would click.
#define OUTPUT_PINS (0x1FF8UL | 0xFC000UL)

struct pin_set {
    uint8_t b, c, d;
};

// All sixteen outputs low, from the first instructions after a reset; the stop circuit pulled up.
void pins_init(void);
bool pins_is_output(uint8_t pin);
void pins_add(struct pin_set *set, uint8_t pin);
// Closes what is not in the set before it opens what is, so that no two valves overlap.
void pins_write(const struct pin_set *high);
void pins_raise(const struct pin_set *set);
void pins_lower(const struct pin_set *set);
// True if the circuit D2 - button - ground is open: pressed, or a wire broken.
bool pins_stop_open(void);
void pins_lamp(bool on);
