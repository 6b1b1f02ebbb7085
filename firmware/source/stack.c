#include "stack.h"

#include <avr/io.h>

#define PAINT 0xC5

extern uint8_t _end; // the end of the variables; no heap is used

// Before main, while nothing is on the stack.
__attribute__((naked, used, section(".init3"))) static void paint(void) {
    for (uint8_t *p = &_end; p <= (uint8_t *)RAMEND; p++) *p = PAINT;
}

uint16_t stack_free(void) {
    const uint8_t *p = &_end;
    while (p <= (uint8_t *)RAMEND && *p == PAINT) p++;
    return p - &_end;
}

uint16_t stack_used(void) {
    return (uint8_t *)RAMEND + 1 - &_end - stack_free();
}
