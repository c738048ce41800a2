// SPDX-License-Identifier: MIT
#include "trainer/base/noise_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Returns sqrt(x), with a tiny number in place of x <= 0. Uses std::sqrt in each lane, because Eigen's own is not
/// rounded correctly.
double root(double x) {
  return std::sqrt(std::max(x, 1e-12));
}
LaneValue root(const LaneValue& x) {
  return x.unaryExpr([](float lane) { return std::sqrt(std::max(lane, 1e-12F)); });
}

struct None {
  template <class Value>
  static Value draw(NoiseNumbers<Value>&, int) {
    if constexpr (std::is_same_v<Value, double>)
      return 0.0;
    else
      return LaneValue::Zero();
  }
  static std::string title(const SensorNoise&) { return "no noise"; }
};

struct Gaussian {
  template <class Value>
  static Value draw(NoiseNumbers<Value>& numbers, int) {
    return numbers.normal();
  }
  static ArrayXd density(const ArrayXd& v, int) { return (-0.5 * v.square()).exp() * 0.3989422804014327; }
  static std::string title(const SensorNoise& noise) { return "N(0, " + shortest_text(noise.scale) + ")"; }
};

struct Uniform {
  template <class Value>
  static Value draw(NoiseNumbers<Value>& numbers, int) {
    return numbers.uniform();
  }
  static ArrayXd density(const ArrayXd& v, int) { return 0.5 * soft_box(v, 1.0); }
  static std::string title(const SensorNoise& noise) {
    return "U(-" + shortest_text(noise.scale) + ", " + shortest_text(noise.scale) + ")";
  }
};

/// Draws n_0 / sqrt((n_1^2 + ... + n_f^2) / f).
struct Student {
  template <class Value>
  static Value draw(NoiseNumbers<Value>& numbers, int freedom) {
    std::array<Value, kMostFreedom + 1> n;
    numbers.normals(std::span(n).first(static_cast<std::size_t>(freedom) + 1));
    Value squares = n[1] * n[1];
    for (int i = 2; i <= freedom; ++i) squares += n[static_cast<std::size_t>(i)] * n[static_cast<std::size_t>(i)];
    using Number = std::conditional_t<std::is_same_v<Value, double>, double, float>;
    return n[0] / root(squares / static_cast<Number>(freedom));
  }
  static ArrayXd density(const ArrayXd& v, int freedom) {
    const double f = freedom;
    const double norm = std::exp(std::lgamma(0.5 * (f + 1.0)) - std::lgamma(0.5 * f)) / std::sqrt(f * std::numbers::pi);
    return norm * (1.0 + v.square() / f).pow(-0.5 * (f + 1.0));
  }
  static std::string title(const SensorNoise& noise) {
    return shortest_text(noise.scale) + " t(" + std::to_string(noise.shape) + ")";
  }
  static constexpr int kMostFreedom = 30;
};

template <class Kind>
constexpr NoiseRow with_functions(NoiseRow row) {
  row.draw = &Kind::template draw<double>;
  row.draw_lanes = &Kind::template draw<LaneValue>;
  if constexpr (requires { &Kind::density; }) row.density = &Kind::density;
  row.title = &Kind::title;
  return row;
}

constexpr std::array kRows = {
    with_functions<None>({.kind = NoiseKind::kNone, .name = "none", .numbers = "", .variance = 0.0, .largest = 0.0}),
    with_functions<Gaussian>({.kind = NoiseKind::kGaussian,
                              .name = "gaussian",
                              .numbers = ":STANDARD_DEVIATION",
                              .variance = 1.0,
                              .largest = kNoLimit}),
    with_functions<Uniform>({.kind = NoiseKind::kUniform,
                             .name = "uniform",
                             .numbers = ":HALF_WIDTH",
                             .variance = 1.0 / 3.0,
                             .largest = 1.0}),
    with_functions<Student>({.kind = NoiseKind::kStudent,
                             .name = "student",
                             .numbers = ":SCALE:FREEDOM",
                             .least_shape = 1,
                             .most_shape = Student::kMostFreedom,
                             .variance = 1.0,
                             .largest = kNoLimit,
                             .tails = true}),
};

}  // namespace

std::span<const NoiseRow> noise_table() {
  return kRows;
}

const NoiseRow& noise_row(NoiseKind kind) {
  return *std::ranges::find(kRows, kind, &NoiseRow::kind);
}

ArrayXd soft_box(const ArrayXd& v, double width) {
  constexpr double kSoftEdge = 0.02;
  return 1.0 / (1.0 + ((v.abs() - width) / (kSoftEdge * width)).min(500.0).exp());
}

}  // namespace nlo::trainer
