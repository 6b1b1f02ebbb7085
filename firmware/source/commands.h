// What the board does with each message.
#pragma once
#include "link.h"

void commands_handle(const struct frame *frame, uint8_t length);
// Tells the host of what has happened by itself.
void commands_tell_events(void);
