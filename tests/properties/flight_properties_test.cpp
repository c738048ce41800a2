// SPDX-License-Identifier: MIT
// Ten million steps in flight: no allocation, lock, page fault or system call, for any measurement. Each detector is
// tested with an event that it must detect.
#include <gtest/gtest.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <limits>
#include <mutex>

#include "bench/random_model.h"
#include "bench/random_structures.h"
#include "tests/properties/traps.h"
#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::kUnderSanitizer;
using testing::Trap;

// With a sanitizer, a step takes ten times as long.
constexpr int kSteps = kUnderSanitizer ? 200'000 : 10'000'000;

// Volatile, so that the compiler cannot drop work whose result is unused.
void* volatile kept_pointer;
volatile float kept_value;

template <class Observer>
void fly(Observer& observer, int steps) {
  bench::RandomUniform random{7};
  // With an input if the observer has one.
  const auto step = [&](float y, auto... dt_s) {
    typename Observer::Output output{};
    for (float& entry : output) entry = y;
    if constexpr (Observer::kDriven) {
      typename Observer::Input input{};
      for (float& entry : input) entry = random();
      return observer.step(output, input, dt_s...);
    } else {
      return observer.step(output, dt_s...);
    }
  };
  for (int k = 0; k < steps; ++k) {
    // All paths: good, out of range, missing, irregular.
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

TEST(Trap, DetectsOperatorNewAndMalloc) {
  {
    Trap trap;
    kept_pointer = new int(1);
    trap.disarm();
    EXPECT_GE(trap.allocations(), 1);
  }
  delete static_cast<int*>(kept_pointer);
  if (kUnderSanitizer) return;
  {
    Trap trap;
    kept_pointer = std::malloc(16);
    trap.disarm();
    EXPECT_EQ(trap.allocations(), 1);
  }
  std::free(kept_pointer);
}

TEST(Trap, DetectsALockThatNobodyElseHolds) {
  std::mutex mutex;
  Trap trap;
  mutex.lock();
  mutex.unlock();
  trap.disarm();
  EXPECT_EQ(trap.locks(), 1);
}

TEST(Trap, DetectsThePageFaultsOfNewPages) {
  constexpr int kPages = 50;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  auto* memory =
      static_cast<char*>(mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(memory, MAP_FAILED);
  madvise(memory, kPages * page, MADV_NOHUGEPAGE);
  const auto touch = [&] {
    for (std::size_t p = 0; p < kPages; ++p) static_cast<volatile char*>(memory)[p * page] = 1;
  };
  Trap trap;
  touch();
  trap.disarm();
  EXPECT_GE(trap.page_faults(), kPages);
  munmap(memory, kPages * page);
}

TEST(Trap, CountsNothingWithoutEvents) {
  Trap trap;
  trap.disarm();
  kept_pointer = new int(1);
  delete static_cast<int*>(kept_pointer);
  EXPECT_EQ(trap.allocations(), 0);
  EXPECT_EQ(trap.locks(), 0);
  EXPECT_EQ(trap.page_faults(), 0);
}

/// Flies under the trap. Other programs may cause a page fault once, but a step that causes page faults does so each
/// time, so the best of three flights is used.
template <class Observer>
void expect_nothing_happens(Observer& observer, int steps) {
  fly(observer, 1000);  // loads code and stack before counting
  long page_faults = 0;
  for (int flight = 0; flight < 3; ++flight) {
    Trap trap;
    fly(observer, steps);
    trap.disarm();
    ASSERT_EQ(trap.allocations(), 0);
    ASSERT_EQ(trap.locks(), 0);
    page_faults = trap.page_faults();
    if (page_faults == 0) break;
  }
  EXPECT_EQ(page_faults, 0);
}

TEST(Flight, TenMillionStepsCauseNoAllocationLockOrPageFault) {
  static constexpr auto kModel = bench::random_kkl_model<Activation::kTanh, 16, 2>();
  KklObserver observer{kModel};
  expect_nothing_happens(observer, kSteps);
}

TEST(Flight, NoStructureOrPolicyCausesAllocationsLocksOrPageFaults) {
  static constexpr auto kPaper = bench::random_kkl_model<Activation::kTanh, 50, 4>();
  static constexpr auto kLuenberger = bench::random_luenberger_model<Activation::kTanh, 16, 2>();
  static constexpr auto kGeneral = bench::random_general_model<Activation::kSilu, 16, 2>();
  static constexpr auto kDriven = bench::random_driven_model<Activation::kTanh, 16, 2>();
  static constexpr auto kCarried = testing::carried_model<float>();
  static constexpr auto kPrior = testing::prior_model<float>();
  KklObserver paper{kPaper};
  KklObserver<decltype(kPaper), Arithmetic::kDeterministic> deterministic{kPaper};
  LuenbergerObserver luenberger{kLuenberger};
  GeneralObserver general{kGeneral};
  DrivenKklObserver driven{kDriven};
  CarriedObserver carried{kCarried};
  PriorObserver prior{kPrior};
  expect_nothing_happens(paper, kSteps / 500);
  expect_nothing_happens(deterministic, kSteps / 500);
  expect_nothing_happens(luenberger, kSteps / 500);
  expect_nothing_happens(general, kSteps / 500);
  expect_nothing_happens(driven, kSteps / 500);
  expect_nothing_happens(carried, kSteps / 500);
  expect_nothing_happens(prior, kSteps / 500);
}

/// Runs `work` in a child process that the kernel kills at its first system call. Returns the exit code, minus the
/// signal that ended the process, or 1000 if the kernel does not support this.
template <class Work>
int run_without_system_calls(const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) _exit(100);
    work();
    syscall(SYS_exit, 0);  // the only system call that is allowed; _exit() would make another
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return 1000;
  if (WIFSIGNALED(status)) return -WTERMSIG(status);
  return WEXITSTATUS(status) == 100 ? 1000 : WEXITSTATUS(status);
}

TEST(Flight, MakesNoSystemCall) {
  if (kUnderSanitizer) GTEST_SKIP() << "a sanitizer allocates memory itself";
  const int control = run_without_system_calls([] { kept_value = static_cast<float>(getppid()); });
  if (control == 1000) GTEST_SKIP() << "no seccomp here";
  ASSERT_EQ(control, -SIGKILL) << "a system call was not noticed";
  static constexpr auto kModel = bench::random_kkl_model<Activation::kTanh, 16, 2>();
  KklObserver observer{kModel};
  EXPECT_EQ(run_without_system_calls([&] { fly(observer, kSteps / 10); }), 0);
}

}  // namespace
}  // namespace nlo
