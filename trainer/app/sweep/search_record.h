// SPDX-License-Identifier: MIT
// The trials of a search as a file. An interrupted search continues from it, and its page is made from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trainer/app/sweep/results.h"

namespace nlo::trainer {

/// One experiment that was drawn.
struct Candidate {
  std::string experiment;    ///< TOML
  std::string difference;    ///< Difference::full from the given experiment; empty: none
  std::string title;         ///< Difference::title
  JobCost cost;              ///< cost of its export in float
  double setup_s = 0.0;      ///< time of a training before and after its steps, on this machine
  double steps_per_s = 0.0;  ///< latest measured speed of its training on this machine
};

/// One training of a candidate.
struct Trial {
  std::size_t candidate = 0;
  int steps = 0;
  bool done = false;
  std::optional<double> error = {};  ///< error on validation runs; empty if done: the training diverged
};

struct SearchRecord {
  std::uint64_t identity = 0;  ///< hash of the experiment, its data and the budget
  double seconds = 0.0;        ///< time for trainings, after candidates were found
  double by_hand_s = 0.0;      ///< time of a full training of the given experiment; 0: it is not a candidate
  std::vector<Candidate> candidates;
  std::vector<std::vector<Trial>> rungs;  ///< rungs that have begun

  /// Returns true if the given experiment can be trained in full at the end, which must not take more than half of the
  /// time.
  bool by_hand_fits() const { return by_hand_s > 0.0 && by_hand_s <= 0.5 * seconds; }

  /// Returns the trial with the smallest error in the last rung. The given experiment is preferred unless another one
  /// is better by more than 2 %, because the seed can change the order within 2 %. Throws codegen::Error if no training
  /// of the rung has an error.
  const Trial& chosen() const;

  /// Returns the last finished trial of a candidate; null: none.
  const Trial* last_of(std::size_t candidate) const;
};

std::string to_json(const SearchRecord& record);

/// Reads a record. Throws codegen::Error if `text` is not one; `place` is the name of its file.
SearchRecord search_record_from_json(const std::string& text, const std::string& place);

}  // namespace nlo::trainer
