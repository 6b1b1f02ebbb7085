// CRC-32 as of Ethernet and zip files.
#pragma once
#include <stdint.h>

#define CRC_BEGIN 0xFFFFFFFFUL

// More bytes; what it comes to at the end is inverted.
uint32_t crc_more(uint32_t crc, const void *bytes, uint16_t length);
