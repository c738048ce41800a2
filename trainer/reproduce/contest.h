// SPDX-License-Identifier: MIT
// Compares our observers with published observers whose code is not in this repository. For each cell of a benchmark it
// gives the errors in %, computed in two ways, and says which observer is ahead.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

/// A cell of a benchmark: errors in %, one for each training seed.
struct Contender {
  std::string model, condition;
  std::optional<double> published;        ///< the smallest published error; empty: there is none
  std::vector<double> components, norms;  ///< the error computed in two ways (smape.h)
};

/// Returns true if the worst seed is below the published number.
bool is_ahead(const Contender& cell, const std::vector<double>& values);

struct Contest {
  std::string title;
  std::vector<Contender> cells;
};

/// Returns "16 of 16 cells ahead by components, 15 of 16 by norms", counting only cells with a published number.
std::string contest_score(const Contest& contest);

std::string contest_text(const Contest& contest);
std::string contest_html(const Contest& contest);

/// Returns a table in the format of NumbersCsv (numbers_csv.h): row is the model, column the condition, paper the
/// published number.
std::string contests_csv(const std::vector<Contest>& contests);

}  // namespace nlo::trainer::reproduction
