// SPDX-License-Identifier: MIT
// The cache in benchmarks: measures the time to load a number of bytes from L1, and evicts data as other programs
// beside a slow loop would.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nlo::bench {

/// Loads `bytes` (a multiple of 512) in the widest vectors of the CPU, without using them.
void load_all(const void* from, std::size_t bytes);

/// A buffer to read through. It is written first, because a buffer that was never written is a single page of zeros and
/// evicts nothing.
class Evictor {
 public:
  /// 256 KB evict everything from an L1 cache; several MB evict everything from L2, too.
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
