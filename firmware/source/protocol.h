// The numbers of the protocol, as firmware/PROTOCOL.md says them. All on the wire is little-endian, as
// the AVR is, and its compiler pads nothing: the structures below are their own encoding.
#pragma once
#include <stdint.h>

#define PROTOCOL_VERSION 1

enum message {
    HELLO = 0x01,
    CONFIG = 0x02,
    CHANNEL = 0x03,
    LOAD = 0x04,
    COMMIT = 0x05,
    START = 0x06,
    STOP = 0x07,
    ESTOP = 0x08,
    CLEAR = 0x09,
    HEARTBEAT = 0x0A,
    WELCOME = 0x81,
    ACK = 0x82,
    STATUS = 0x83,
    ERROR = 0x84,
    EVENT = 0x85,
};

enum error {
    BUSY = 1,            // another session is alive
    NO_SESSION = 2,      // HELLO first: the board was reset, or another host took over
    OLD_SEQUENCE = 3,    // older than the last request
    UNKNOWN = 4,         // no such message, or not of its length
    WRONG_STATE = 5,     // not in this state
    BAD_PIN = 6,         // no output, or taken
    OUT_OF_LIMITS = 7,   // a setting beyond what WELCOME says
    BAD_TABLE = 8,       // order, both valves open, a pulse out of range; the detail is the row
    OTHER_TABLE = 9,     // the CRC is not that of the table in the board
    STOP_CIRCUIT_OPEN = 10,
    OTHER_VERSION = 11,
    NOTHING_LOADED = 12, // CHANNEL or LOAD before CONFIG, or COMMIT before all channels
};

enum event { DONE = 1, LINK_LOST = 2, STOP_PRESSED = 3, RESET = 4 };

enum state { IDLE = 0, ARMED = 1, RUNNING = 2, ESTOPPED = 3, FAULT = 4 };

// Bits of what has gone wrong since the last CLEAR.
enum fault { FAULT_LINK = 1, FAULT_WATCHDOG = 2, FAULT_STOP_PIN = 4, FAULT_STOP_MESSAGE = 8 };

enum kind { NOTHING = 0, VALVES = 1, SERVOS = 2 };
enum safe { HOLD = 0, VENT = 1, RELEASE = 2, REST = 3 };

#define MAX_CHANNELS 8
#define TABLE_BYTES 1024
#define MAX_PAYLOAD 60
#define MAX_REPLY 32

#define LEAST_PULSE_US 500
#define MOST_PULSE_US 2400
#define LEAST_PERIOD_US 100000UL
#define MOST_PERIOD_US 600000000UL
#define LEAST_TIMEOUT_MS 100
#define MOST_TIMEOUT_MS 5000
#define DEFAULT_TIMEOUT_MS 500

struct hello {
    uint8_t version;
    uint32_t nonce;
};

struct welcome {
    uint32_t nonce;
    uint8_t version;
    uint8_t kinds; // bit 0 valves, bit 1 servos
    uint8_t channels;
    uint8_t state;
    uint8_t faults;
    uint8_t reset_cause; // the register MCUSR
    uint16_t table_bytes;
    uint16_t tick_us;
    uint16_t least_pulse_us;
    uint16_t most_pulse_us;
    uint32_t least_period_us;
    uint32_t most_period_us;
    uint32_t pins; // bit n: pin Dn, bit 14 + n: pin An
};

// CONFIG: what holds of all channels.
struct settings {
    uint8_t kind;
    uint8_t safe;
    uint8_t channels;
    uint16_t rows; // valves: changes in the table; servos: points of each channel
    uint32_t period_us;
};

struct channel {
    uint8_t pin; // valves: the one that inflates
    uint8_t vent_pin;
    uint16_t least_us; // servos: limits of the pulse, and its rest
    uint16_t most_us;
    uint16_t rest_us;
};

struct channel_message {
    uint8_t index;
    struct channel channel;
};

// A row of the valves' table: what is open from a time on, bit n for channel n.
struct change {
    uint32_t at_us;
    uint8_t inflate;
    uint8_t vent;
};

struct load {
    uint16_t offset;
    uint8_t bytes[MAX_PAYLOAD - 2];
};

struct start {
    uint32_t cycles; // 0: until it is stopped
    uint16_t timeout_ms;
};

struct status {
    uint8_t state;
    uint8_t faults;
    uint32_t cycle;
    uint32_t phase_us;
    uint16_t stack_used; // the deepest since the reset, bytes
    uint16_t stack_free;
    uint16_t bad_frames; // since the reset
};

struct error_reply {
    uint8_t code;
    uint8_t request;
    uint16_t detail;
};

struct event_message {
    uint8_t event;
    uint8_t state;
};
