// SPDX-License-Identifier: MIT
// The kinds of symmetry that an experiment may declare, one row each: groups of which every element g turns a run of
// the plant into another one, f(g x, g u) = g f(x, u) and h(g x) = g h(x).
//
// To add one: a row in kinds.cpp. Tests run over the table.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// What an element does: v becomes matrix * v for each declared vector, and each declared angle moves on.
struct Element {
  Eigen::MatrixXd matrix;
  double turns = 0.0;  ///< of a full turn
};

using Uniform = std::function<float()>;  ///< the next number in [0, 1)

inline constexpr int kNoVectors = -1, kAnyLength = 0;

struct SymmetryKind {
  enum class Channels { kNone, kScalars, kAngles };  ///< kScalars: each is a vector of one component

  std::string_view name, meaning;
  int components;     ///< of each of its `vectors`; kAnyLength: from two on, all alike
  Channels channels;  ///< what its `channels` are
  /// A random element, all equally likely.
  ///   fold  > 0: multiples of 1/fold of a turn alone
  Element (*draw)(int components, int fold, const Uniform& uniform);
  /// A few that stand for all: with the identity they have the group's mean, and what they make of a vector has the
  /// deviations that the group gives it.
  std::vector<Element> (*others)(int components, int fold);
};

std::span<const SymmetryKind> symmetry_kinds();
std::vector<std::string> symmetry_kind_names();
const SymmetryKind& symmetry_kind(std::string_view name);  ///< of the table

}  // namespace nlo::trainer
