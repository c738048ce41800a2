// SPDX-License-Identifier: MIT
// Candidate sets of eigenvalues: a few forms that were found to be good by hand, at every speed between the limits from
// the length of a run and from its sample period.
#pragma once

#include <array>
#include <vector>

namespace nlo::trainer {

/// Eigenvalues of one channel [1/s].
struct ModeBank {
  std::vector<std::array<double, 2>> pairs;  ///< complex pairs re +- i im
  std::vector<double> real;
  int form = 0;        ///< index of its form, which has another speed
  int resonances = 0;  ///< number of pairs, the last ones, that resonances.h has added

  int rows() const { return 2 * static_cast<int>(pairs.size()) + static_cast<int>(real.size()); }
  double slowest() const;  ///< min |Re lambda|
  double fastest() const;  ///< max |lambda|

  /// Returns the bank with all time constants divided by `faster`, to three digits.
  ModeBank scaled(double faster) const;
};

/// Returns the forms at speeds with a ratio of 1.8, the slowest first within a form. No time constant is longer than
/// `horizon_s`, and no |lambda| is above 1.5 / `sample_period_s`, where z is y with its noise. Forms have at most
/// `most_rows` rows, but there is always one form. Not empty for horizon_s > 20 sample_period_s.
std::vector<ModeBank> mode_banks(double sample_period_s, double horizon_s, int most_rows);

}  // namespace nlo::trainer
