// How deep the stack has been: memory is painted at the reset, and what is still paint has not been used.
#pragma once
#include <stdint.h>

uint16_t stack_used(void);
uint16_t stack_free(void);
