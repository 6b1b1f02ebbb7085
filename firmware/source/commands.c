#include "commands.h"
#include "machine.h"
#include "pins.h"
#include "program.h"
#include "servos.h"
#include "stack.h"
#include "valves.h"

#include <string.h>
#include <util/atomic.h>

extern uint8_t reset_cause;

struct reply {
    uint8_t type;
    uint8_t length;
    union {
        uint8_t bytes[MAX_REPLY];
        struct welcome welcome;
        struct status status;
        struct error_reply error;
    };
};

_Static_assert(sizeof(struct welcome) <= MAX_REPLY, "the longest reply");

// Who drives: 0 is nobody.
static uint32_t session;
static uint8_t last_sequence;
static struct reply last_reply;

static uint32_t silence_us(void) {
    uint32_t us;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) us = machine.silence_us;
    return us;
}

static void heard(void) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) machine.silence_us = 0;
}

static void reply_with_error(struct reply *r, uint8_t code, uint8_t request, uint16_t detail) {
    r->type = ERROR;
    r->length = sizeof r->error;
    r->error = (struct error_reply){code, request, detail};
}

static void reply_with_welcome(struct reply *r, uint32_t nonce) {
    r->type = WELCOME;
    r->length = sizeof r->welcome;
    r->welcome = (struct welcome){
        .nonce = nonce,
        .version = PROTOCOL_VERSION,
        .kinds = _BV(VALVES - 1) | _BV(SERVOS - 1),
        .channels = MAX_CHANNELS,
        .state = machine.state,
        .faults = machine.faults,
        .reset_cause = reset_cause,
        .table_bytes = TABLE_BYTES,
        .tick_us = VALVE_TICK_US,
        .least_pulse_us = LEAST_PULSE_US,
        .most_pulse_us = MOST_PULSE_US,
        .least_period_us = LEAST_PERIOD_US,
        .most_period_us = MOST_PERIOD_US,
        .pins = OUTPUT_PINS,
    };
}

static void reply_with_status(struct reply *r) {
    r->type = STATUS;
    r->length = sizeof r->status;
    struct status *s = &r->status;
    s->stack_free = stack_free();
    s->stack_used = stack_used();
    s->bad_frames = link_bad_frames();
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        s->state = machine.state;
        s->faults = machine.faults;
        s->cycle = machine.cycle;
        s->phase_us = program.settings.kind == SERVOS ? servos_phase_us() : valves_phase_us();
    }
}

static uint8_t configure(const struct settings *settings) {
    uint8_t code;
    // The pins may be others now: all low, and nothing of the old program comes any more.
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        machine.state = IDLE;
        servos_release();
        const struct pin_set none = {0, 0, 0};
        pins_write(&none);
        code = program_configure(settings);
    }
    return code;
}

static uint8_t start(const struct start *s) {
    if (machine.state != ARMED) return WRONG_STATE;
    if (s->timeout_ms < LEAST_TIMEOUT_MS || s->timeout_ms > MOST_TIMEOUT_MS) return OUT_OF_LIMITS;
    uint8_t code = 0;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        // Again, as an interrupt may have come between.
        if (machine.state == ARMED) machine_start(s);
        else code = WRONG_STATE;
    }
    return code;
}

static uint8_t clear(void) {
    if (machine.state != ESTOPPED && machine.state != FAULT) return 0;
    if (pins_stop_open()) return STOP_CIRCUIT_OPEN;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        machine.faults = 0;
        machine.state = IDLE;
    }
    return 0;
}

// Executes a request of the session; gives an error, or 0.
static uint8_t execute(const struct frame *f, uint8_t length, uint16_t *detail) {
    const void *p = f->payload;
    bool may_load = machine.state == IDLE || machine.state == ARMED;
    uint8_t code = UNKNOWN;
    switch (f->type) {
    case CONFIG:
        if (length != sizeof(struct settings)) return UNKNOWN;
        return may_load ? configure(p) : WRONG_STATE;
    case CHANNEL:
        if (length != sizeof(struct channel_message)) return UNKNOWN;
        return machine.state == IDLE ? program_set_channel(p) : WRONG_STATE;
    case LOAD:
        if (length < 3) return UNKNOWN;
        return machine.state == IDLE ? program_load(p, length - 2) : WRONG_STATE;
    case COMMIT:
        if (length != sizeof(uint32_t)) return UNKNOWN;
        if (!may_load) return WRONG_STATE;
        code = program_check(*(const uint32_t *)p, detail);
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
            if (code == 0 && machine.state == IDLE) machine.state = ARMED;
        }
        return code;
    case START:
        return length == sizeof(struct start) ? start(p) : UNKNOWN;
    case STOP:
        if (length != 0) return UNKNOWN;
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
            if (machine.state == RUNNING) machine_leave(ARMED);
        }
        return 0;
    case CLEAR:
        return length == 0 ? clear() : UNKNOWN;
    case HEARTBEAT:
        return length == 0 ? 0 : UNKNOWN;
    }
    return code;
}

static void handle_hello(const struct frame *f, struct reply *reply) {
    const struct hello *hello = (const void *)f->payload;
    bool alive = session != 0 && silence_us() < machine.timeout_us;
    if (f->session == 0) {
        reply_with_error(reply, NO_SESSION, HELLO, 0);
    } else if (hello->version != PROTOCOL_VERSION) {
        reply_with_error(reply, OTHER_VERSION, HELLO, PROTOCOL_VERSION);
    } else if (f->session == session) {
        // Said again, as the answer was lost; it begins nothing anew.
        heard();
        reply_with_welcome(reply, hello->nonce);
    } else if (alive) {
        reply_with_error(reply, BUSY, HELLO, 0);
    } else {
        session = f->session;
        last_sequence = f->sequence;
        last_reply.type = 0;
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
            if (machine.state == RUNNING) machine_leave(IDLE);
            if (machine.state == ARMED) machine.state = IDLE;
            machine.timeout_us = DEFAULT_TIMEOUT_MS * 1000UL;
            machine.silence_us = 0;
            machine.event = 0;
        }
        reply_with_welcome(reply, hello->nonce);
    }
}

void commands_handle(const struct frame *f, uint8_t length) {
    struct reply reply;
    struct reply *out = &reply;
    if (f->type == ESTOP && length == 0) {
        // From anybody, at any time.
        machine_estop(FAULT_STOP_MESSAGE);
        reply.type = ACK;
        reply.length = 0;
    } else if (f->type == HELLO && length == sizeof(struct hello)) {
        handle_hello(f, &reply);
    } else if (session == 0 || f->session != session) {
        reply_with_error(&reply, NO_SESSION, f->type, 0);
    } else {
        int8_t ahead = f->sequence - last_sequence;
        // What is old may come from a buffer somewhere, and its host be gone.
        if (ahead >= 0) heard();
        out = &last_reply;
        if (ahead < 0 || (ahead == 0 && last_reply.type == 0)) {
            out = &reply;
            reply_with_error(out, OLD_SEQUENCE, f->type, last_sequence);
        } else if (ahead > 0) {
            last_sequence = f->sequence;
            uint16_t detail = 0;
            uint8_t code = execute(f, length, &detail);
            if (code) {
                reply_with_error(out, code, f->type, detail);
            } else if (f->type == HEARTBEAT) {
                reply_with_status(out);
            } else {
                out->type = ACK;
                out->length = 0;
            }
        }
        // Else it was said twice: the same answer, and it is not done again.
    }
    link_send(out->type, f->session, f->sequence, out->bytes, out->length);
}

void commands_tell_events(void) {
    uint8_t event;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        event = machine.event;
        machine.event = 0;
    }
    if (!event) return;
    struct event_message message = {event, machine.state};
    link_send(EVENT, session, 0, &message, sizeof message);
}
