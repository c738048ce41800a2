// SPDX-License-Identifier: MIT
// The memory of an observer's steps: its blocks do not overlap, are aligned and can be returned; exhaustion is
// reported.
#include "bindings/c/step_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace nlo::c_interface {
namespace {

TEST(StepMemoryPieces, AreDisjointAlignedAndReusable) {
  StepMemory memory(1 << 16);
  std::vector<void*> pieces;
  for (const std::size_t size : {0U, 1U, 63U, 64U, 65U, 1000U, 4096U}) {
    void* piece = memory.take(size);
    ASSERT_NE(piece, nullptr);
    EXPECT_TRUE(memory.owns(piece));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(piece) % alignof(std::max_align_t), 0U);
    EXPECT_GE(StepMemory::size_of(piece), size);
    std::memset(piece, static_cast<int>(pieces.size()) + 1, StepMemory::size_of(piece));
    pieces.push_back(piece);
  }
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t k = 0; k < StepMemory::size_of(pieces[i]); ++k)
      ASSERT_EQ(static_cast<unsigned char*>(pieces[i])[k], i + 1) << i;
  for (void* piece : pieces) memory.give_back(piece);
  for (int times = 0; times < 10000; ++times) {
    void* piece = memory.take(1000);
    ASSERT_EQ(piece, pieces[5]);
    memory.give_back(piece);
  }
  EXPECT_FALSE(memory.ran_out());
  int other = 0;
  EXPECT_FALSE(memory.owns(&other));
  EXPECT_FALSE(memory.owns(nullptr));
}

TEST(StepMemoryPieces, ReportExhaustion) {
  StepMemory memory(4096);
  EXPECT_EQ(memory.take(1 << 20), nullptr);
  EXPECT_TRUE(memory.ran_out());
  EXPECT_EQ(memory.take(SIZE_MAX), nullptr);
  int count = 0;
  while (memory.take(100) != nullptr) ++count;
  EXPECT_EQ(count, 4096 / (128 + 16));
}

TEST(StepMemoryPieces, ServeTheInnermostUse) {
  StepMemory outer(4096), inner(4096);
  EXPECT_EQ(StepMemory::in_use(), nullptr);
  {
    const StepMemory::Use use(&outer);
    EXPECT_EQ(StepMemory::in_use(), &outer);
    {
      const StepMemory::Use other(&inner);
      EXPECT_EQ(StepMemory::in_use(), &inner);
    }
    EXPECT_EQ(StepMemory::in_use(), &outer);
  }
  EXPECT_EQ(StepMemory::in_use(), nullptr);
}

}  // namespace
}  // namespace nlo::c_interface
