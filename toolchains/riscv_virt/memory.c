// SPDX-License-Identifier: MIT
// Functions that a compiler may call in any program, for targets without a C library. The pointers are volatile, or the
// compiler would turn the loop into a call of itself.
#include <stddef.h>

void* memcpy(void* restrict to, const void* restrict from, size_t count);
void* memmove(void* to, const void* from, size_t count);
void* memset(void* at, int value, size_t count);

void* memcpy(void* restrict to, const void* restrict from, size_t count) {
  volatile unsigned char* target = to;
  const unsigned char* source = from;
  for (; count > 0; --count) *target++ = *source++;
  return to;
}

void* memmove(void* to, const void* from, size_t count) {
  volatile unsigned char* target = to;
  const unsigned char* source = from;
  if (target < source) return memcpy(to, from, count);
  while (count > 0) {
    --count;
    target[count] = source[count];
  }
  return to;
}

void* memset(void* at, int value, size_t count) {
  volatile unsigned char* target = at;
  for (; count > 0; --count) *target++ = (unsigned char)value;
  return at;
}
