// SPDX-License-Identifier: MIT
#include "trainer/base/parallel.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

namespace nlo::trainer {
namespace {

TEST(ThreadPool, RunsEachTaskOnceForAnyNumberOfTasksAndThreads) {
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

TEST(ThreadPool, NeverRunsTwoTasksAtOnceOnTheScratchOfOneThread) {
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

TEST(ThreadPool, RethrowsTheExceptionOfATaskAndStaysUsable) {
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

TEST(ThreadPool, ZeroThreadsMeansAtLeastOne) {
  EXPECT_GE(ThreadPool(0).threads(), 1);
}

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define NLO_ADDRESS_SANITIZER
#endif
#endif

#if !defined(NLO_ADDRESS_SANITIZER)  // its shadow memory exceeds any limit on address space
/// Limits the address space to the memory that is mapped now plus `more` bytes.
void limit_address_space(rlim_t more) {
  long pages = 0;
  std::FILE* const statm = std::fopen("/proc/self/statm", "r");
  if (statm == nullptr || std::fscanf(statm, "%ld", &pages) != 1) std::_Exit(3);
  std::fclose(statm);
  const rlim_t bytes = static_cast<rlim_t>(pages) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + more;
  const rlimit limit = {bytes, bytes};
  if (::setrlimit(RLIMIT_AS, &limit) != 0) std::_Exit(4);
}

/// Makes two pools, because the note about missing threads must be printed only once.
[[noreturn]] void run_on_too_many_threads(int wanted) {
  bool each_once = true;
  int threads = 0;
  for (int pools = 0; pools < 2; ++pools) {
    ThreadPool pool(wanted);
    threads = pool.threads();
    std::vector<std::atomic<int>> runs(500);
    pool.run(500, [&](int index, int) { ++runs[static_cast<std::size_t>(index)]; });
    for (const auto& times : runs) each_once = each_once && times == 1;
  }
  std::fprintf(stderr, "the end\n");
  std::_Exit(each_once && threads >= 1 && threads < wanted ? 0 : 1);
}

TEST(ThreadPoolDeathTest, RunsOnTheAvailableThreadsAndSaysSoOnceIfTheSystemRefusesMore) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        limit_address_space(rlim_t{200} << 20U);
        run_on_too_many_threads(1024);
      },
      ::testing::ExitedWithCode(0),
      "^nlo: runs on [0-9]+ of 1024 threads \\(.*\\); the result is the same, but takes longer\nthe end");
}

TEST(ThreadPoolDeathTest, RefusesANumberOfThreadsThatExceedsMemory) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        limit_address_space(rlim_t{4} << 20U);  // less than one stack
        run_on_too_many_threads(2000000000);
      },
      ::testing::ExitedWithCode(0), "^nlo: runs on 1 of 2000000000 threads \\(not enough memory\\)");
}
#endif

}  // namespace
}  // namespace nlo::trainer
