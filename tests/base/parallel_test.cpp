// SPDX-License-Identifier: MIT
#include "trainer/base/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace nlo::trainer {
namespace {

TEST(ThreadPool, RunsEachTaskOnceWhateverTheNumbersOfTasksAndThreads) {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (int round = 0; round < 200; ++round) {
      const int count = round % 23;
      std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
      std::atomic<bool> known = true;
      pool.run(count, [&](int index, int thread) {
        ++runs[static_cast<std::size_t>(index)];
        if (thread < 0 || thread >= threads) known = false;
      });
      for (const auto& times : runs) ASSERT_EQ(times.load(), 1);
      ASSERT_TRUE(known.load());
    }
  }
}

TEST(ThreadPool, NeverRunsTwoTasksOnOneThreadsScratchAtOnce) {
  ThreadPool pool(3);
  std::vector<std::atomic<int>> in_use(3);
  std::atomic<int> clashes = 0;
  pool.run(2000, [&](int, int thread) {
    auto& scratch = in_use[static_cast<std::size_t>(thread)];
    if (++scratch != 1) ++clashes;
    --scratch;
  });
  EXPECT_EQ(clashes.load(), 0);
}

TEST(ThreadPool, ThrowsATasksExceptionAgainAndGoesOnWorking) {
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    const auto failing = [](int index, int) {
      if (index == 7) throw std::runtime_error("seven");
    };
    EXPECT_THROW(pool.run(20, failing), std::runtime_error);
    std::atomic<int> done = 0;
    EXPECT_NO_THROW(pool.run(20, [&](int, int) { ++done; }));
    EXPECT_EQ(done.load(), 20);
  }
}

TEST(ThreadPool, ZeroThreadsTakesAtLeastOne) {
  EXPECT_GE(ThreadPool(0).threads(), 1);
}

}  // namespace
}  // namespace nlo::trainer
