// The serial line: bytes, COBS frames, checksums.
#pragma once
#include "protocol.h"

#include <stdbool.h>

#define HEAD 6
#define CRC_BYTES 4

struct frame {
    uint8_t type;
    uint32_t session;
    uint8_t sequence;
    uint8_t payload[MAX_PAYLOAD + CRC_BYTES]; // the last bytes of a frame are its CRC
};

void link_init(void);
// The next whole frame with a right checksum, and the length of its payload.
bool link_receive(struct frame *frame, uint8_t *length);
void link_send(uint8_t type, uint32_t session, uint8_t sequence, const void *payload, uint8_t length);
// Frames that were broken, since the reset.
uint16_t link_bad_frames(void);
