// Firmware that runs a gait on an ATmega328P (Arduino Uno, Nano) at 16 MHz; see firmware/PROTOCOL.md.
#include "clock.h"
#include "commands.h"
#include "link.h"
#include "machine.h"
#include "pins.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

// Set before variables are cleared.
uint8_t reset_cause __attribute__((section(".noinit")));

// Right after the reset: outputs are driven low, and the watchdog, if it made the reset, is tamed.
__attribute__((naked, used, section(".init3"))) static void begin(void) {
    reset_cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
    PORTB = 0;
    PORTC = 0;
    PORTD = 0;
    DDRB = 0x1F;
    DDRC = 0x3F;
    DDRD = 0xF8;
}

// Dark: idle. Blinking slowly: armed. Lit: running. Blinking fast: stopped, needs CLEAR.
static void show_state(void) {
    uint16_t ms = clock_ms();
    switch (machine.state) {
    case IDLE: pins_lamp(false); break;
    case ARMED: pins_lamp(ms & 0x200); break;
    case RUNNING: pins_lamp(true); break;
    default: pins_lamp(ms & 0x40); break;
    }
}

int main(void) {
    pins_init();
    clock_init();
    link_init();
    if (reset_cause & _BV(WDRF)) {
        machine.state = FAULT;
        machine.faults = FAULT_WATCHDOG;
    }
    machine.event = RESET;
    wdt_enable(WDTO_250MS);
    set_sleep_mode(SLEEP_MODE_IDLE);
    sei();
    static struct frame frame;
    for (;;) {
        // Fed only while both this loop and the clock are alive.
        if (clock_has_ticked()) wdt_reset();
        uint8_t length = 0;
        bool received = link_receive(&frame, &length);
        if (received) commands_handle(&frame, length);
        commands_tell_events();
        show_state();
        if (!received) sleep_mode();
    }
}
