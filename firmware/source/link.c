#include "link.h"
#include "crc.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <string.h>

// Of powers of two, so that a byte counts around.
#define RX_SIZE 64
#define TX_SIZE 128

static volatile uint8_t rx[RX_SIZE], rx_in, rx_out;
static volatile uint8_t tx[TX_SIZE], tx_in, tx_out;
static uint16_t bad_frames;

void link_init(void) {
    UCSR0A = _BV(U2X0);
    UBRR0 = 16; // 115200 baud, 2 % fast, as the boot loader of these boards is
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

ISR(USART_RX_vect) {
    uint8_t byte = UDR0;
    uint8_t next = (rx_in + 1) % RX_SIZE;
    // A byte too many is lost, and with it its frame, which the checksum tells.
    if (next == rx_out) return;
    rx[rx_in] = byte;
    rx_in = next;
}

ISR(USART_UDRE_vect) {
    UDR0 = tx[tx_out];
    tx_out = (tx_out + 1) % TX_SIZE;
    if (tx_out == tx_in) UCSR0B &= ~_BV(UDRIE0);
}

static void put(uint8_t byte) {
    uint8_t next = (tx_in + 1) % TX_SIZE;
    while (next == tx_out) {}
    tx[tx_in] = byte;
    tx_in = next;
    UCSR0B |= _BV(UDRIE0);
}

void link_send(uint8_t type, uint32_t session, uint8_t sequence, const void *payload, uint8_t length) {
    uint8_t bytes[HEAD + MAX_REPLY + CRC_BYTES];
    bytes[0] = type;
    for (uint8_t i = 0; i < 4; i++, session >>= 8) bytes[1 + i] = session;
    bytes[5] = sequence;
    for (uint8_t i = 0; i < length; i++) bytes[HEAD + i] = ((const uint8_t *)payload)[i];
    uint8_t end = HEAD + length;
    uint32_t crc = ~crc_more(CRC_BEGIN, bytes, end);
    for (uint8_t i = 0; i < CRC_BYTES; i++, crc >>= 8) bytes[end++] = crc;
    // COBS: each zero becomes the distance to the next; a zero ends the frame.
    for (uint8_t from = 0; from <= end;) {
        uint8_t to = from;
        while (to < end && bytes[to]) to++;
        put(to - from + 1);
        while (from < to) put(bytes[from++]);
        from++;
    }
    put(0);
}

bool link_receive(struct frame *frame, uint8_t *length) {
    static uint8_t filled; // bytes of the frame so far
    static uint8_t left;   // until the next code byte
    static bool begun, bad, zero_due;
    uint8_t *bytes = (uint8_t *)frame;
    while (rx_out != rx_in) {
        uint8_t byte = rx[rx_out];
        rx_out = (rx_out + 1) % RX_SIZE;
        if (byte == 0) {
            bool whole = begun && !bad && left == 0 && filled >= HEAD + CRC_BYTES;
            if (whole) {
                uint8_t end = filled - CRC_BYTES;
                uint32_t crc;
                memcpy(&crc, bytes + end, CRC_BYTES);
                whole = crc == ~crc_more(CRC_BEGIN, bytes, end);
                *length = end - HEAD;
            }
            if (begun && !whole) bad_frames++;
            begun = bad = zero_due = false;
            filled = left = 0;
            if (whole) return true;
            continue;
        }
        begun = true;
        if (left == 0) {
            left = byte - 1;
            if (!zero_due) {
                zero_due = true;
                continue;
            }
            byte = 0;
        } else {
            left--;
        }
        if (filled == sizeof *frame) bad = true;
        else bytes[filled++] = byte;
    }
    return false;
}

uint16_t link_bad_frames(void) {
    return bad_frames;
}
