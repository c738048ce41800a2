// SPDX-License-Identifier: MIT
// The memory of an observer's steps. The reference writes equations with temporary vectors. Their memory during a
// step comes from here. It is allocated once with the observer.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

namespace nlo::c_interface {

class StepMemory {
 public:
  explicit StepMemory(std::size_t bytes);

  /// `size` bytes as malloc aligns them. Null where no such piece is left.
  void* take(std::size_t size) noexcept;
  /// Returns a piece from take().
  void give_back(void* piece) noexcept;
  bool owns(const void* piece) const noexcept;
  /// How many bytes a piece has, at least those it was taken for.
  static std::size_t size_of(const void* piece) noexcept;

  /// take() has had to refuse.
  bool ran_out() const { return ran_out_; }

  /// During its lifetime, allocations of this thread inside of the library come from `memory`, as long as there is some
  /// (library_malloc.cpp). Null: nothing does.
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
    std::size_t kind;  ///< a piece has 2^kind bytes behind its head
    Head* next;        ///< free one of this kind
  };
  static constexpr std::size_t kSmallest = 6, kKinds = 48;

  std::unique_ptr<Head[]> all_;
  std::size_t heads_, used_ = 0;  ///< in heads: pieces that were ever taken stand in front
  std::array<Head*, kKinds> free_{};
  bool ran_out_ = false;
};

}  // namespace nlo::c_interface
