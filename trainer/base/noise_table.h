// SPDX-License-Identifier: MIT
// The distributions of measurement noise. A row has all properties that nlo needs, so training, tests, filters and
// texts support a new noise alike. To add one, extend NoiseKind and this table.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "trainer/base/noise.h"

namespace nlo::trainer {

/// Source of random numbers: one at a time (evaluation), or eight (training).
template <class Value>
class NoiseNumbers {
 public:
  virtual Value uniform() = 0;  ///< U(-1, 1)
  virtual Value normal() = 0;   ///< N(0, 1)
  /// Draws all.size() independent normal numbers. The source decides their order.
  virtual void normals(std::span<Value> all) = 0;

 protected:
  ~NoiseNumbers() = default;
};

inline constexpr int kNoiseLanes = 8;
using LaneValue = Eigen::Array<float, kNoiseLanes, 1>;

struct NoiseRow {
  NoiseKind kind;
  std::string_view name;     ///< name in the form name:SCALE or name:SCALE:SHAPE
  std::string_view numbers;  ///< numbers after the name, for messages: ":SCALE"; empty: none
  /// Range of the second number, an integer. least > most: there is no second number.
  int least_shape = 1, most_shape = 0;

  // All values are for scale 1; the scale of a sensor multiplies the draws.
  double variance;     ///< nominal variance; Student's t: variance of the normal numerator
  double largest;      ///< bound of |v|; infinite: none
  bool tails = false;  ///< v may be arbitrarily large
  /// Draws one value. The two functions are one template, instantiated twice.
  double (*draw)(NoiseNumbers<double>& numbers, int shape) = nullptr;
  LaneValue (*draw_lanes)(NoiseNumbers<LaneValue>& numbers, int shape) = nullptr;
  /// p(v); null: v has no density.
  Eigen::ArrayXd (*density)(const Eigen::ArrayXd& v, int shape) = nullptr;
  std::string (*title)(const SensorNoise& noise) = nullptr;  ///< for readers: "N(0, 0.5)"

  bool has_scale() const { return !numbers.empty(); }
  bool has_shape() const { return least_shape <= most_shape; }
  bool bounded() const { return largest < std::numeric_limits<double>::infinity(); }
};

std::span<const NoiseRow> noise_table();
const NoiseRow& noise_row(NoiseKind kind);

/// Returns 1 for |v| <= width and 0 outside, with an edge of 2 % of the width, so that a particle just beyond it keeps
/// a small weight.
Eigen::ArrayXd soft_box(const Eigen::ArrayXd& v, double width);

}  // namespace nlo::trainer
