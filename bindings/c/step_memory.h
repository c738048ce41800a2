// SPDX-License-Identifier: MIT
// The memory for an observer's steps, which is allocated once with the observer. The reference observer writes
// equations with temporary vectors; during a step they are stored here.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

namespace nlo::c_interface {

class StepMemory {
 public:
  explicit StepMemory(std::size_t bytes);

  /// Returns `size` bytes, aligned as by malloc, or null if no such piece is left.
  void* take(std::size_t size) noexcept;
  /// Takes back a piece that take() returned.
  void give_back(void* piece) noexcept;
  bool owns(const void* piece) const noexcept;
  /// Returns the number of bytes of a piece, which is at least the size that was asked for.
  static std::size_t size_of(const void* piece) noexcept;

  /// Returns true if take() has failed.
  bool ran_out() const { return ran_out_; }

  /// During its lifetime, allocations of this thread inside of the library come from `memory`, until it is used up
  /// (library_malloc.cpp). Null: they come from the system.
  class Use {
   public:
    explicit Use(StepMemory* memory) noexcept;
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    StepMemory* before_;
  };
  static StepMemory* in_use() noexcept;

 private:
  struct alignas(std::max_align_t) Head {
    std::size_t kind;  ///< the piece has 2^kind bytes after its head
    Head* next;        ///< next free piece of this kind
  };
  static constexpr std::size_t kSmallest = 6, kKinds = 48;

  std::unique_ptr<Head[]> all_;
  std::size_t heads_, used_ = 0;  ///< counted in heads. The pieces used so far are at the start
  std::array<Head*, kKinds> free_{};
  bool ran_out_ = false;
};

}  // namespace nlo::c_interface
