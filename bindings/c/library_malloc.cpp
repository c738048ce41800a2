// SPDX-License-Identifier: MIT
// malloc and related functions for the code of this library (by --wrap of the linker; those of the program do not
// change). During a step of an observer they take memory from the observer, otherwise from the system.
#include <cstddef>
#include <cstring>

#include "bindings/c/step_memory.h"

using nlo::c_interface::StepMemory;

extern "C" {

void* __real_malloc(std::size_t size);
void* __real_calloc(std::size_t count, std::size_t size);
void* __real_realloc(void* piece, std::size_t size);
void __real_free(void* piece);

void* __wrap_malloc(std::size_t size) {
  StepMemory* memory = StepMemory::in_use();
  void* piece = memory == nullptr ? nullptr : memory->take(size);
  return piece != nullptr ? piece : __real_malloc(size);
}

void* __wrap_calloc(std::size_t count, std::size_t size) {
  std::size_t bytes = 0;
  StepMemory* memory = StepMemory::in_use();
  void* piece = memory == nullptr || __builtin_mul_overflow(count, size, &bytes) ? nullptr : memory->take(bytes);
  return piece != nullptr ? std::memset(piece, 0, bytes) : __real_calloc(count, size);
}

void __wrap_free(void* piece) {
  StepMemory* memory = StepMemory::in_use();
  if (memory != nullptr && memory->owns(piece))
    memory->give_back(piece);
  else
    __real_free(piece);
}

void* __wrap_realloc(void* piece, std::size_t size) {
  StepMemory* memory = StepMemory::in_use();
  if (memory == nullptr || !memory->owns(piece)) return __real_realloc(piece, size);
  const std::size_t held = StepMemory::size_of(piece);
  if (size <= held) return piece;
  void* larger = __wrap_malloc(size);
  if (larger == nullptr) return nullptr;
  std::memcpy(larger, piece, held);
  memory->give_back(piece);
  return larger;
}

}  // extern "C"
