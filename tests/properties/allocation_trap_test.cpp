// SPDX-License-Identifier: MIT
// A hundred thousand steps of an observer allocate nothing: operator new and malloc are counted while a trap is armed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

#include "bench/random_model.h"
#include "bench/random_structures.h"

// A sanitizer brings its own malloc; there only operator new is watched.
#if defined(__SANITIZE_ADDRESS__)
#define NLO_TRAP_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NLO_TRAP_MALLOC 0
#endif
#endif
#if !defined(NLO_TRAP_MALLOC) && defined(__GLIBC__)
#define NLO_TRAP_MALLOC 1
#endif

namespace {

// volatile: a compiler may take it that operator new touches nothing of ours.
volatile bool armed = false;
volatile int allocations = 0;

void note_allocation() {
  if (armed) allocations = allocations + 1;
}

/// Counts what is allocated while it lives.
class Trap {
 public:
  Trap() {
    allocations = 0;
    armed = true;
  }
  ~Trap() { armed = false; }
  Trap(const Trap&) = delete;
  Trap& operator=(const Trap&) = delete;
};

}  // namespace

#if NLO_TRAP_MALLOC
extern "C" void* __libc_malloc(std::size_t size) noexcept;
extern "C" void* malloc(std::size_t size) noexcept {
  note_allocation();
  return __libc_malloc(size);
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

namespace {

// Without these the compiler may prove an allocation useless and drop it.
void* volatile kept_pointer;
volatile float kept_value;

TEST(AllocationTrap, SeesOperatorNewAndMalloc) {
  {
    Trap trap;
    kept_pointer = new int(1);
  }
  EXPECT_GE(allocations, 1);
  delete static_cast<int*>(kept_pointer);
#if NLO_TRAP_MALLOC
  {
    Trap trap;
    kept_pointer = std::malloc(16);
  }
  EXPECT_EQ(allocations, 1);
  std::free(kept_pointer);
#endif
}

TEST(AllocationTrap, IsSilentWhenDisarmed) {
  { Trap trap; }
  const std::vector<int> elsewhere(100);
  EXPECT_EQ(allocations, 0) << elsewhere.size();
}

template <class Observer>
void fly(Observer& observer, int steps) {
  nlo::bench::RandomUniform random{7};
  // With an input where the observer takes one.
  const auto step = [&](float y, auto... dt_s) {
    if constexpr (Observer::kDriven) {
      return observer.step(y, random(), dt_s...);
    } else {
      return observer.step(y, dt_s...);
    }
  };
  for (int k = 0; k < steps; ++k) {
    // Every path: good, out of range, missing, irregular.
    const float y = 3.0F * random();
    auto status = step(k % 100 == 3 ? 1e30F : y);
    if (k % 100 == 7) status = step(std::numeric_limits<float>::quiet_NaN());
    if (k % 100 == 11) status = step(y, 0.013F);
    if (k % 100 == 13) status = step(y, 0.21F);
    if constexpr (Observer::Model::kHasSteadyState) {
      if (k % 1000 == 999) status = observer.warm_start(y);
    }
    kept_value = observer.estimate()[0] + (observer.in_domain() ? 1.0F : 0.0F) + static_cast<float>(status);
  }
}

TEST(AllocationTrap, NoStructureAllocates) {
  static constexpr auto kLuenberger = nlo::bench::random_luenberger_model<nlo::Activation::kTanh, 16, 2>();
  static constexpr auto kGeneral = nlo::bench::random_general_model<nlo::Activation::kSilu, 16, 2>();
  static constexpr auto kDriven = nlo::bench::random_driven_model<nlo::Activation::kTanh, 16, 2>();
  nlo::LuenbergerObserver luenberger{kLuenberger};
  nlo::GeneralObserver general{kGeneral};
  nlo::DrivenKklObserver driven{kDriven};
  {
    Trap trap;
    fly(luenberger, 20'000);
    fly(general, 20'000);
    fly(driven, 20'000);
  }
  EXPECT_EQ(allocations, 0);
}

TEST(AllocationTrap, HundredThousandStepsAllocateNothing) {
  static constexpr auto kModel = nlo::bench::random_kkl_model<nlo::Activation::kTanh, 16, 2>();
  static constexpr auto kPaperModel = nlo::bench::random_kkl_model<nlo::Activation::kTanh, 50, 4>();
  nlo::KklObserver observer{kModel};
  nlo::KklObserver paper_observer{kPaperModel};
  {
    Trap trap;
    fly(observer, 100'000);
    fly(paper_observer, 1'000);
  }
  EXPECT_EQ(allocations, 0);
}

}  // namespace
