// SPDX-License-Identifier: MIT
// Sets of eigenvalues to choose from: a few forms that have been found good by hand, at every speed between the
// limits set by the length of a run and by its sample period.
#pragma once

#include <array>
#include <vector>

namespace nlo::trainer {

/// Eigenvalues of one channel [1/s].
struct ModeBank {
  std::vector<std::array<double, 2>> pairs;  ///< complex pairs re +- i im
  std::vector<double> real;
  int form = 0;        ///< which of the forms it is, at another speed
  int resonances = 0;  ///< how many of the pairs, the last ones, resonances.h has added

  int rows() const { return 2 * static_cast<int>(pairs.size()) + static_cast<int>(real.size()); }
  double slowest() const;  ///< min |Re lambda|
  double fastest() const;  ///< max |lambda|

  /// All time constants divided by `faster`, to three digits.
  ModeBank scaled(double faster) const;
};

/// The forms at speeds a factor of 1.8 apart, slowest first within a form: no time constant is longer than `horizon_s`,
/// and no |lambda| beyond 1.5 / `sample_period_s`, where z is y with its noise. Forms have at most `most_rows` rows,
/// but there is always one. Not empty for horizon_s > 20 sample_period_s.
std::vector<ModeBank> mode_banks(double sample_period_s, double horizon_s, int most_rows);

}  // namespace nlo::trainer
