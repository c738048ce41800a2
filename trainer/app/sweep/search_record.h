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
  std::string difference;    ///< Difference::full from the experiment as it stands; empty: that one
  std::string title;         ///< Difference::title
  JobCost cost;              ///< cost of its export in float
  double setup_s = 0.0;      ///< time of a training before and after its steps on this machine
  double steps_per_s = 0.0;  ///< speed of its training on this machine, as last measured
};

/// One training of a candidate.
struct Trial {
  std::size_t candidate = 0;
  int steps = 0;
  bool done = false;
  std::optional<double> error = {};  ///< on validation runs; empty when done: its training diverged
};

struct SearchRecord {
  std::uint64_t identity = 0;  ///< hash of the experiment, its data and the budget
  double seconds = 0.0;        ///< for trainings, after candidates were looked for
  double by_hand_s = 0.0;      ///< full training time of the given experiment; 0: it is no candidate
  std::vector<Candidate> candidates;
  std::vector<std::vector<Trial>> rungs;  ///< rungs that were begun

  /// The experiment as it stands is trained in full at last, unless that takes more than half of the time.
  bool by_hand_fits() const { return by_hand_s > 0.0 && by_hand_s <= 0.5 * seconds; }

  /// Returns the trial with the least error in the last rung. The given experiment wins unless another one is better by
  /// more than 2 %, because a seed may change the order within 2 %. Throws codegen::Error if no training of the rung
  /// has an error.
  const Trial& chosen() const;

  /// The last trial of a candidate that is done; null: none.
  const Trial* last_of(std::size_t candidate) const;
};

std::string to_json(const SearchRecord& record);

/// Throws codegen::Error where `text` is no record; `place` names its file.
SearchRecord search_record_from_json(const std::string& text, const std::string& place);

}  // namespace nlo::trainer
