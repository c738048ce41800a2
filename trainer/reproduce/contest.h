// SPDX-License-Identifier: MIT
// Our observers against published ones whose code is not here: percentages cell by cell in two readings, and who is
// ahead.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

/// A cell of a benchmark: errors in %, one for each training seed.
struct Contender {
  std::string model, condition;
  std::optional<double> published;        ///< the best of theirs; none: ours beside it, nothing to compare with
  std::vector<double> components, norms;  ///< the two readings (smape.h)
};

/// The worst seed is below the published number.
bool is_ahead(const Contender& cell, const std::vector<double>& values);

struct Contest {
  std::string title;
  std::vector<Contender> cells;
};

/// "16 of 16 cells ahead by components, 15 of 16 by norms", of those with a published number.
std::string contest_score(const Contest& contest);

std::string contest_text(const Contest& contest);
std::string contest_html(const Contest& contest);

/// As numbers_csv() (numbers_csv.h): row the model, column the condition, paper the published number.
std::string contests_csv(const std::vector<Contest>& contests);

}  // namespace nlo::trainer::reproduction
