#include "pins.h"

#include <avr/io.h>
#include <avr/pgmspace.h>

#define OUTPUTS_B 0x1F // D8 to D12
#define OUTPUTS_C 0x3F // A0 to A5
#define OUTPUTS_D 0xF8 // D3 to D7
#define STOP_PIN 2     // of port D
#define LAMP_PIN 5     // of port B

void pins_init(void) {
    PORTB = 0;
    PORTC = 0;
    PORTD = _BV(STOP_PIN);
    DDRB = OUTPUTS_B | _BV(LAMP_PIN);
    DDRC = OUTPUTS_C;
    DDRD = OUTPUTS_D;
}

bool pins_is_output(uint8_t pin) {
    return pin < 20 && (OUTPUT_PINS >> pin & 1);
}

void pins_add(struct pin_set *set, uint8_t pin) {
    static const uint8_t bits[8] PROGMEM = {1, 2, 4, 8, 16, 32, 64, 128};
    if (pin < 8) set->d |= pgm_read_byte(&bits[pin]);
    else if (pin < 14) set->b |= pgm_read_byte(&bits[pin - 8]);
    else set->c |= pgm_read_byte(&bits[pin - 14]);
}

void pins_lower(const struct pin_set *set) {
    PORTB &= ~(set->b & OUTPUTS_B);
    PORTC &= ~(set->c & OUTPUTS_C);
    PORTD &= ~(set->d & OUTPUTS_D);
}

void pins_raise(const struct pin_set *set) {
    PORTB |= set->b & OUTPUTS_B;
    PORTC |= set->c & OUTPUTS_C;
    PORTD |= set->d & OUTPUTS_D;
}

void pins_write(const struct pin_set *high) {
    struct pin_set low = {~high->b, ~high->c, ~high->d};
    pins_lower(&low);
    pins_raise(high);
}

bool pins_stop_open(void) {
    return PIND & _BV(STOP_PIN);
}

// One instruction, which no interrupt can split.
void pins_lamp(bool on) {
    if (on) PORTB |= _BV(LAMP_PIN);
    else PORTB &= ~_BV(LAMP_PIN);
}
