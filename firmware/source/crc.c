#include "crc.h"

#include <avr/pgmspace.h>

// Of half a byte: sixteen entries are quick enough.
static const uint32_t table[16] PROGMEM = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
};

uint32_t crc_more(uint32_t crc, const void *bytes, uint16_t length) {
    for (const uint8_t *b = bytes; length--; b++) {
        crc = crc >> 4 ^ pgm_read_dword(&table[(crc ^ *b) & 15]);
        crc = crc >> 4 ^ pgm_read_dword(&table[(crc ^ *b >> 4) & 15]);
    }
    return crc;
}
