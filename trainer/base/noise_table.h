// SPDX-License-Identifier: MIT
// The distributions that measurement noise may have. A row has all that nlo asks of one, so that a new noise trains,
// tests, filters and is explained alike: add it to NoiseKind and here.
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
  /// So many independent normal numbers; which of them is drawn first is the source's matter.
  virtual void normals(std::span<Value> all) = 0;

 protected:
  ~NoiseNumbers() = default;
};

inline constexpr int kNoiseLanes = 8;
using LaneValue = Eigen::Array<float, kNoiseLanes, 1>;

struct NoiseRow {
  NoiseKind kind;
  std::string_view name;     ///< as it is written: name:SCALE, or name:SCALE:SHAPE
  std::string_view numbers;  ///< the numbers after the name, for messages: ":SCALE"; empty: none
  /// Range of the second number, an integer; least > most: there is none.
  int least_shape = 1, most_shape = 0;

  // All of scale 1; a sensor's scale multiplies the draws.
  double variance;     ///< nominal: of t, which may have none, that of its normal numerator
  double largest;      ///< |v| that is never exceeded; infinite: it may be anything
  bool tails = false;  ///< now and then v is far off, however far
  /// One draw. The two are one function, instantiated twice.
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

/// 1 within |v| <= width, 0 outside, with an edge of 2 % of the width: a particle just beyond it keeps a chance.
Eigen::ArrayXd soft_box(const Eigen::ArrayXd& v, double width);

}  // namespace nlo::trainer
