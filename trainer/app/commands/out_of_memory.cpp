// SPDX-License-Identifier: MIT
#include "trainer/app/commands/out_of_memory.h"

#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <string_view>

namespace nlo::trainer {
namespace {

[[noreturn]] void end() {
  constexpr std::string_view kMessage =
      "nlo: error: not enough memory; for a training use fewer or shorter trajectories, or fewer --threads\n";
  static std::atomic<bool> said{false};
  while (said.exchange(true)) ::pause();  // another thread prints the message and ends the program
  const ssize_t ignored = ::write(STDERR_FILENO, kMessage.data(), kMessage.size());
  static_cast<void>(ignored);
  std::_Exit(1);
}

}  // namespace

void end_where_memory_ends() {
  std::set_new_handler(end);
}

}  // namespace nlo::trainer

// Eigen calls malloc and not operator new; the linker redirects these calls here (--wrap).
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __real_malloc(std::size_t size);
void* __real_realloc(void* old, std::size_t size);
void* __wrap_malloc(std::size_t size);
void* __wrap_realloc(void* old, std::size_t size);

void* __wrap_malloc(std::size_t size) {
  void* const result = __real_malloc(size);
  if (result == nullptr && size > 0 && std::get_new_handler() != nullptr) nlo::trainer::end();
  return result;
}

void* __wrap_realloc(void* old, std::size_t size) {
  void* const result = __real_realloc(old, size);
  if (result == nullptr && size > 0 && std::get_new_handler() != nullptr) nlo::trainer::end();
  return result;
}
}
// NOLINTEND(bugprone-reserved-identifier)
