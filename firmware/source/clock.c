#include "clock.h"
#include "machine.h"
#include "program.h"
#include "servos.h"
#include "valves.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

// The interrupt comes this much before its time: more than any other interrupt lasts.
#define LEAD (12 * COUNTS_PER_US)

static uint16_t due; // when the present step is to happen, in counts
static uint16_t step = VALVE_TICK_US * COUNTS_PER_US;
static volatile bool ticked;
static volatile uint16_t ms;

void clock_init(void) {
    TCCR1A = 0;
    TCCR1B = _BV(CS11); // 16 MHz / 8: two counts a microsecond, around in 32.8 ms
    due = TCNT1 + step;
    OCR1A = due - LEAD;
    TIMSK1 = _BV(OCIE1A);
}

void clock_wait_until_due(void) {
    while ((int16_t)(TCNT1 - due) < 0) {}
}

ISR(TIMER1_COMPA_vect) {
    bool servos = program.settings.kind == SERVOS;
    uint16_t us = step / COUNTS_PER_US;
    step = servos ? servos_step() : valves_step();
    due += step; // never "now plus": lateness does not add up
    uint16_t at = due - LEAD;
    OCR1A = at;
    // Too late for a compare match, which would come 33 ms late: as soon as can be, and catch up.
    if ((int16_t)(TCNT1 - at) >= -2) OCR1A = TCNT1 + 4;

    static uint16_t rest_us;
    for (rest_us += us; rest_us >= 1000; rest_us -= 1000) ms++;
    ticked = true;
    machine_tick(us);
    if (!servos) return;
    // Long, but done before the next step: the shortest pulse lasts longer. The serial line must not wait.
    sei();
    servos_prepare();
    cli();
}

bool clock_has_ticked(void) {
    bool had = ticked;
    ticked = false;
    return had;
}

uint16_t clock_ms(void) {
    uint16_t now;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) now = ms;
    return now;
}
