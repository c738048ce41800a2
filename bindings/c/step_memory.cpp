// SPDX-License-Identifier: MIT
#include "bindings/c/step_memory.h"

#include <algorithm>
#include <bit>
#include <functional>

namespace nlo::c_interface {
namespace {

thread_local StepMemory* used_here = nullptr;

}  // namespace

StepMemory::StepMemory(std::size_t bytes)
    : all_(std::make_unique<Head[]>(bytes / sizeof(Head))), heads_(bytes / sizeof(Head)) {}

void* StepMemory::take(std::size_t size) noexcept {
  const std::size_t kind = std::max<std::size_t>(kSmallest, std::bit_width(size == 0 ? 0 : size - 1));
  if (kind < kKinds) {
    if (Head* head = free_[kind]) {
      free_[kind] = head->next;
      return head + 1;
    }
    const std::size_t needed = 1 + (std::size_t{1} << kind) / sizeof(Head);
    if (needed <= heads_ - used_) {
      Head* head = &all_[used_];
      used_ += needed;
      head->kind = kind;
      return head + 1;
    }
  }
  ran_out_ = true;
  return nullptr;
}

void StepMemory::give_back(void* piece) noexcept {
  Head* head = static_cast<Head*>(piece) - 1;
  head->next = free_[head->kind];
  free_[head->kind] = head;
}

bool StepMemory::owns(const void* piece) const noexcept {
  const std::less<> before;  // orders any two pointers
  return !before(piece, all_.get()) && before(piece, all_.get() + heads_);
}

std::size_t StepMemory::size_of(const void* piece) noexcept {
  return std::size_t{1} << (static_cast<const Head*>(piece) - 1)->kind;
}

StepMemory::Use::Use(StepMemory* memory) noexcept : before_(used_here) {
  used_here = memory;
}

StepMemory::Use::~Use() {
  used_here = before_;
}

StepMemory* StepMemory::in_use() noexcept {
  return used_here;
}

}  // namespace nlo::c_interface
