// SPDX-License-Identifier: MIT
#include "tests/properties/traps.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/resource.h>

#include <cstdlib>
#include <new>

namespace {

// volatile, because a compiler may assume that operator new does not touch variables of the program.
thread_local volatile bool armed = false;
volatile int allocations_seen = 0;
volatile int locks_seen = 0;

void note_allocation() {
  if (armed) allocations_seen = allocations_seen + 1;
}

/// Returns the library's function of this name, which a function of this program replaces.
template <class Function>
Function next_one(const char* name) {
  if (armed) locks_seen = locks_seen + 1;
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Returns the number of minor and major page faults of this thread.
long page_faults_so_far() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace

#if defined(__GLIBC__)
#if !defined(__SANITIZE_ADDRESS__)
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NLO_SANITIZER_HAS_MALLOC
#endif
#endif
#if !defined(NLO_SANITIZER_HAS_MALLOC)
extern "C" void* __libc_malloc(std::size_t size) noexcept;
extern "C" void* malloc(std::size_t size) noexcept {
  note_allocation();
  return __libc_malloc(size);
}
#endif
#endif

extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  return next_one<int (*)(pthread_mutex_t*)>("pthread_mutex_lock")(mutex);
}
extern "C" int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  return next_one<int (*)(pthread_mutex_t*)>("pthread_mutex_trylock")(mutex);
}
extern "C" int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  return next_one<int (*)(pthread_rwlock_t*)>("pthread_rwlock_rdlock")(lock);
}
extern "C" int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  return next_one<int (*)(pthread_rwlock_t*)>("pthread_rwlock_wrlock")(lock);
}
#endif

void* operator new(std::size_t size) {
  note_allocation();
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace nlo::testing {

Trap::Trap() {
  allocations_seen = 0;
  locks_seen = 0;
  faults_after_ = faults_before_ = page_faults_so_far();
  armed = true;
}

void Trap::disarm() {
  if (!armed) return;
  armed = false;
  faults_after_ = page_faults_so_far();
}

int Trap::allocations() const {
  return allocations_seen;
}
int Trap::locks() const {
  return locks_seen;
}

}  // namespace nlo::testing
