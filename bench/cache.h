// SPDX-License-Identifier: MIT
// The cache in benchmarks: the time to load so many bytes from L1, and how to evict the data that a slow loop's
// neighbours would evict.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlo::bench {

/// Loads `bytes` (a multiple of 512) in vectors as long as the CPU has, and does nothing with them.
void load_all(const void* from, std::size_t bytes);

/// A buffer to walk through. It is written at first: one that never was is a single page of zeros, and evicts nothing.
class Evictor {
 public:
  /// 256 KB push everything out of an L1 cache; several MB out of L2 too.
  explicit Evictor(std::size_t bytes) : lines_(bytes / sizeof(Line)) {
    for (std::size_t i = 0; i < lines_.size(); ++i) lines_[i].words[0] = i;
  }

  void evict() {
    std::uint64_t sum = 0;
    for (Line& line : lines_) sum += ++line.words[0];
    asm volatile("" : : "r"(sum) : "memory");
  }

 private:
  struct alignas(64) Line {
    std::uint64_t words[8];
  };
  std::vector<Line> lines_;
};

}  // namespace nlo::bench
