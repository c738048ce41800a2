// SPDX-License-Identifier: MIT
#include "trainer/prove/activation_slope.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/prove/rounding.h"

namespace nlo::trainer {

using codegen::ActivationRow;

namespace {

constexpr double kNarrowest = 1e-9;  // narrower intervals get a constant instead of a chord

/// Bounds the error of about ten roundings and one library function, in values and slopes at arguments of size `size`.
/// Assumes |value| <= 1.1 |x| and |slope| <= 1.1.
double slack(double size) {
  constexpr double kMany = 64.0;
  static_assert(kMany > 8.0 * kLibraryUlps);
  return kMany * kUnit * (1.0 + size);
}
double slack(double low, double high, double at = 0.0) {
  return slack(std::abs(low) + std::abs(high) + std::abs(at));
}

/// Widens the range of a function over [low, high]: `lowest` and `highest` come from the two ends, and the function's
/// turning points between the ends are added.
void include_turns(const codegen::TurningPoints& turns, double low, double high, double& lowest, double& highest) {
  for (const codegen::TurningPoint& turn : turns) {
    if (low > turn.at + turn.margin || high < turn.at - turn.margin) continue;
    lowest = std::min(lowest, turn.value);
    highest = std::max(highest, turn.value);
  }
}

struct Line {
  double centre, gradient, remainder;
};

/// Returns a line parallel to the chord of `function` on [low, high], shifted so that the remainder is symmetric. Its
/// `centre` is the line's value at `at`.
///   bend  largest second derivative of the function
template <class Function>
Line chord(const Function& function, double bend, double low, double high, double at) {
  constexpr int kIntervals = 8;
  const double width = high - low, h = width / kIntervals;
  const double gradient = (function(high) - function(low)) / width;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (int i = 0; i <= kIntervals; ++i) {
    const double x = low + h * i, left = function(x) - gradient * (x - at);
    least = std::min(least, left);
    most = std::max(most, left);
  }
  // Between two points, a function differs from its chord by at most h^2 / 8 times its second derivative.
  return {0.5 * (least + most), gradient, 0.5 * (most - least) + bend * h * h / 8.0 + slack(low, high, at)};
}

}  // namespace

SlopeRange slope_range(const ActivationRow& activation, double low, double high) {
  const double a = activation.slope(low), b = activation.slope(high);
  SlopeRange range{std::min(a, b), std::max(a, b)};
  include_turns(activation.slope_turns, low, high, range.low, range.high);
  if (!activation.kink_at_zero) {  // straight pieces have exact slopes
    range.low -= slack(low, high);
    range.high += slack(low, high);
  }
  return range;
}

SlopeLine slope_line(const ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     const Eigen::VectorXd& v) {
  // Wider intervals get a constant, because a chord over much of the curve is no better.
  constexpr double kWidest = 2.0;
  const Eigen::Index n = v.size();
  SlopeLine line{Eigen::VectorXd(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const SlopeRange range = slope_range(activation, low(i), high(i));
    const double width = high(i) - low(i);
    line.centre(i) = 0.5 * (range.low + range.high);
    line.remainder(i) = 0.5 * (range.high - range.low) + slack(0.0);
    if (!activation.kink_at_zero && width > kNarrowest && width < kWidest) {
      const Line of_chord = chord(activation.slope, activation.largest_slope_change, low(i), high(i), v(i));
      if (std::abs(of_chord.centre) <= kSteepest) {
        line.centre(i) = of_chord.centre;
        line.gradient(i) = of_chord.gradient;
        line.remainder(i) = of_chord.remainder;
      }
    }
    line.range(i) = std::max(range.high - line.centre(i), line.centre(i) - range.low) + slack(0.0);
  }
  return line;
}

ActivationLine activation_line(const ActivationRow& activation, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high) {
  const Eigen::Index n = low.size();
  ActivationLine line{Eigen::VectorXd(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    if (high(i) - low(i) <= kNarrowest) {  // slopes are below 1.1
      line.offset(i) = activation.value(low(i));
      line.remainder(i) = 2.0 * kNarrowest + slack(low(i), high(i));
    } else if (activation.kink_at_zero) {  // parallel to the chord, midway between it and the kink
      const double a = activation.value(low(i)), b = activation.value(high(i));
      line.gradient(i) = (b - a) / (high(i) - low(i));
      const double gap = 0.5 * std::max(a - line.gradient(i) * low(i), 0.0);
      line.offset(i) = a - line.gradient(i) * low(i) - gap;
      line.remainder(i) = gap + slack(low(i), high(i));
    } else {
      const Line of_chord = chord(activation.value, activation.largest_curvature, low(i), high(i), 0.0);
      line.offset(i) = of_chord.centre;
      line.gradient(i) = of_chord.gradient;
      line.remainder(i) = of_chord.remainder;
    }
  }
  return line;
}

void activated_range(const ActivationRow& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     Eigen::VectorXd& lowest, Eigen::VectorXd& highest) {
  lowest.resize(low.size());
  highest.resize(low.size());
  for (Eigen::Index i = 0; i < low.size(); ++i) {
    const double a = activation.value(low(i)), b = activation.value(high(i));
    lowest(i) = std::min(a, b);
    highest(i) = std::max(a, b);
    include_turns(activation.value_turns, low(i), high(i), lowest(i), highest(i));
    if (activation.kink_at_zero) continue;
    lowest(i) -= slack(std::abs(lowest(i)));
    highest(i) += slack(std::abs(highest(i)));
  }
}

}  // namespace nlo::trainer
