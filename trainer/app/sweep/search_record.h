// SPDX-License-Identifier: MIT
// What a search has tried so far, as a file: an interrupted one goes on from it, and its page is made from it.
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
  JobCost cost;              ///< of its export in float
  double setup_s = 0.0;      ///< what a training of it takes here before and after its steps
  double steps_per_s = 0.0;  ///< of its training here, as last measured
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
  double by_hand_s = 0.0;      ///< what the experiment as it stands takes in full; 0: it is no candidate
  std::vector<Candidate> candidates;
  std::vector<std::vector<Trial>> rungs;  ///< that were begun

  /// The experiment as it stands is trained in full at last, unless that takes more than half of the time.
  bool by_hand_fits() const { return by_hand_s > 0.0 && by_hand_s <= 0.5 * seconds; }

  /// Of the last rung the least error: the experiment as it stands, unless another is better by more than 2 %, within
  /// which a seed may change the order. Throws codegen::Error where no training of the rung has an error.
  const Trial& chosen() const;

  /// The last trial of a candidate that is done; null: none.
  const Trial* last_of(std::size_t candidate) const;
};

std::string to_json(const SearchRecord& record);

/// Throws codegen::Error where `text` is no record; `place` names its file.
SearchRecord search_record_from_json(const std::string& text, const std::string& place);

}  // namespace nlo::trainer
