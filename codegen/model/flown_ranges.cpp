// SPDX-License-Identifier: MIT
#include "codegen/model/flown_ranges.h"

#include <algorithm>
#include <cmath>

#include "codegen/model/field_checks.h"

namespace nlo::codegen {
namespace {

constexpr double kMostTurns = 65536.0;  // at this angle float resolves 2^-8 of a turn
constexpr double kMostWraps = 64.0;     // at this value float resolves 2^-18 of W

}  // namespace

double relative_wrap(const Model& m, int reading) {
  if (reading >= m.ny() || m.outputs[static_cast<std::size_t>(reading)].wrap > 0.0) return 0.0;
  // A missing output decays to a point of its declared range. Subtracting multiples of W would shift this point.
  const std::vector<int>& fades = m.failures.outputs;
  if (std::find(fades.begin(), fades.end(), reading) != fades.end()) return 0.0;
  if (!is_relative(m, reading) || !seen_of_turn(m, reading).empty()) return 0.0;
  const double low = m.output_min(reading), high = m.output_max(reading);
  const double least = 2.0 * std::max({high - low, std::abs(low), std::abs(high)});
  if (!(least > 0.0) || !std::isfinite(least)) return 0.0;
  return std::max(std::exp2(std::ceil(std::log2(least))), 0x1p-100);
}

FlownRanges flown_ranges(const Model& m) {
  const Eigen::VectorXd low = reading_min(m), high = reading_max(m);
  FlownRanges ranges{low, high, Eigen::VectorXd::Zero(m.nr()), low, high};
  for (int j = 0; j < m.ny(); ++j) {
    const double turn = m.outputs[static_cast<std::size_t>(j)].wrap, wrap = relative_wrap(m, j);
    if (turn == 0.0 && wrap == 0.0) continue;
    ranges.wrap(j) = turn + wrap;  // one of them is 0
    ranges.max(j) = turn > 0.0 ? kMostTurns * turn : kMostWraps * wrap;
    ranges.min(j) = -ranges.max(j);
    ranges.kept_max(j) = 0.5 * ranges.wrap(j);
    ranges.kept_min(j) = -ranges.kept_max(j);
  }
  return ranges;
}

double whole_turns(double angle, double turn) {
  const double turns = angle / turn;
  return std::abs(turns) <= 0.5 ? 0.0 : std::round(turns);
}

}  // namespace nlo::codegen
