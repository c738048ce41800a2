// SPDX-License-Identifier: MIT
// Compares our observers with published ones whose code is not in this repository: percentages cell by cell, computed
// in two ways, and who is ahead.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

/// A cell of a benchmark: errors in %, one for each training seed.
struct Contender {
  std::string model, condition;
  std::optional<double> published;        ///< the best of their errors; empty: nothing to compare with
  std::vector<double> components, norms;  ///< the error computed in two ways (smape.h)
};

/// Returns true if the worst seed is below the published number.
bool is_ahead(const Contender& cell, const std::vector<double>& values);

struct Contest {
  std::string title;
  std::vector<Contender> cells;
};

/// Returns "16 of 16 cells ahead by components, 15 of 16 by norms", counting cells with a published number.
std::string contest_score(const Contest& contest);

std::string contest_text(const Contest& contest);
std::string contest_html(const Contest& contest);

/// Returns a table as numbers_csv() (numbers_csv.h) does: row is the model, column the condition, paper the published
/// number.
std::string contests_csv(const std::vector<Contest>& contests);

}  // namespace nlo::trainer::reproduction
