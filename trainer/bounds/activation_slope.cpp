// SPDX-License-Identifier: MIT
#include "trainer/bounds/activation_slope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nlo::trainer {
namespace {

// silu falls to its minimum and rises from there; its slope, odd about 1/2, is steepest at 2.39936 and least at minus
// that.
constexpr double kSiluLowestAt = -1.2784645, kSiluLowest = -0.2784646;
constexpr double kSiluSteepestAt = 2.39936, kSiluRadius = 0.59984;

constexpr double kNarrowest = 1e-9;  // of an interval that has a chord

bool contains(double low, double high, double v) {
  constexpr double kMargin = 1e-4;  // of the places above
  return low <= v + kMargin && high >= v - kMargin;
}

struct Line {
  double centre, gradient, remainder;
};

/// The chord of `function` on [low, high], moved to the middle of what it leaves; `centre` is its value at `at`.
///   bend  the function's largest second derivative
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
  // Between two points a function leaves its chord by at most h^2 / 8 times its second derivative.
  return {0.5 * (least + most), gradient, 0.5 * (most - least) + bend * h * h / 8.0};
}

}  // namespace

double activated(const std::string& activation, double v) {
  if (activation == "relu") return std::max(v, 0.0);
  if (activation == "silu") return v / (1.0 + std::exp(-v));
  return std::tanh(v);
}

double activation_slope(const std::string& activation, double v) {
  if (activation == "relu") return v > 0.0 ? 1.0 : 0.0;
  if (activation == "silu") {
    const double s = 1.0 / (1.0 + std::exp(-v));
    return s + v * s * (1.0 - s);
  }
  const double t = std::tanh(v);
  return 1.0 - t * t;
}

SlopeRange slope_range(const std::string& activation, double low, double high) {
  // At a kink any slope between those of its sides is one of the map.
  if (activation == "relu") return {low > 0.0 ? 1.0 : 0.0, high >= 0.0 ? 1.0 : 0.0};
  const double a = activation_slope(activation, low), b = activation_slope(activation, high);
  SlopeRange range{std::min(a, b), std::max(a, b)};
  if (activation == "silu") {
    if (contains(low, high, kSiluSteepestAt)) range.high = 0.5 + kSiluRadius;
    if (contains(low, high, -kSiluSteepestAt)) range.low = 0.5 - kSiluRadius;
  } else if (low <= 0.0 && high >= 0.0) {
    range.high = 1.0;
  }
  return range;
}

SlopeLine slope_line(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     const Eigen::VectorXd& v) {
  constexpr double kWidest = 2.0;  // a chord is no better than a constant over much of the curve
  const Eigen::Index n = v.size();
  SlopeLine line{Eigen::VectorXd(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const SlopeRange range = slope_range(activation, low(i), high(i));
    const double width = high(i) - low(i);
    line.centre(i) = 0.5 * (range.low + range.high);
    line.remainder(i) = 0.5 * (range.high - range.low);
    if (activation != "relu" && width > kNarrowest && width < kWidest) {
      const double bend = activation == "silu" ? 0.5 : 2.0;  // largest second derivative of the slope: 0.41, 2
      const Line of_chord =
          chord([&](double x) { return activation_slope(activation, x); }, bend, low(i), high(i), v(i));
      line.centre(i) = of_chord.centre;
      line.gradient(i) = of_chord.gradient;
      line.remainder(i) = of_chord.remainder;
    }
    line.range(i) = std::max(range.high - line.centre(i), line.centre(i) - range.low);
  }
  return line;
}

ActivationLine activation_line(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  const Eigen::Index n = low.size();
  ActivationLine line{Eigen::VectorXd(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    if (high(i) - low(i) <= kNarrowest) {  // slopes are below 1.1
      line.offset(i) = activated(activation, low(i));
      line.remainder(i) = 2.0 * kNarrowest;
    } else if (activation == "relu") {  // its chord and the line below it through the kink
      const double a = std::max(low(i), 0.0), b = std::max(high(i), 0.0);
      line.gradient(i) = (b - a) / (high(i) - low(i));
      line.remainder(i) = 0.5 * std::max(a - line.gradient(i) * low(i), 0.0);
      line.offset(i) = a - line.gradient(i) * low(i) - line.remainder(i);
    } else {
      const Line of_chord = chord([&](double x) { return activated(activation, x); }, 0.8, low(i), high(i), 0.0);
      line.offset(i) = of_chord.centre;  // second derivatives: tanh 0.77, silu 0.5
      line.gradient(i) = of_chord.gradient;
      line.remainder(i) = of_chord.remainder;
    }
  }
  return line;
}

void activated_range(const std::string& activation, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                     Eigen::VectorXd& lowest, Eigen::VectorXd& highest) {
  lowest.resize(low.size());
  highest.resize(low.size());
  for (Eigen::Index i = 0; i < low.size(); ++i) {
    const double a = activated(activation, low(i)), b = activated(activation, high(i));
    lowest(i) = std::min(a, b);
    highest(i) = std::max(a, b);
    if (activation == "silu" && contains(low(i), high(i), kSiluLowestAt)) lowest(i) = kSiluLowest;
  }
}

}  // namespace nlo::trainer
