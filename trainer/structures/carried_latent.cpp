// SPDX-License-Identifier: MIT
#include "trainer/structures/carried_latent.h"

#include <nlo/carried_observer.h>

#include <algorithm>
#include <array>
#include <utility>

#include "codegen/model/carried.h"

namespace nlo::trainer {

using codegen::kAxes;

CarriedLatent::CarriedLatent(const LatentShape& shape, int outputs, const std::vector<double>& eigenvalues,
                             const std::vector<double>& steps_s, bool fixed)
    : LatentDynamics(shape.rows),
      filter_(shape, eigenvalues, steps_s, fixed),
      outputs_(outputs),
      command_(shape.ahead(outputs) > 0),
      steps_s_(steps_s) {}

std::vector<float> CarriedLatent::attitudes(const SegmentGroup& group) const {
  std::vector<float> all(static_cast<std::size_t>(group.length) * kGroup * kAxes * kAxes);
  for (int lane = 0; lane < kGroup; ++lane) {
    const auto rate = [&](int time, double(&w)[kAxes]) {
      for (int c = 0; c < kAxes; ++c)
        w[c] = static_cast<double>(group.readings[group.at(outputs_ + c, time) + static_cast<std::size_t>(lane)]);
    };
    double attitude[kAxes][kAxes] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int time = 0; time < group.length; ++time) {
      const std::size_t place = static_cast<std::size_t>(time) * kGroup + static_cast<std::size_t>(lane);
      float* to = all.data() + place * kAxes * kAxes;
      for (const auto& row : attitude)
        for (const double entry : row) *to++ = static_cast<float>(entry);
      if (time + 1 == group.length) break;
      double w[kAxes], w_next[kAxes], theta[kAxes];
      rate(command_ ? time + 1 : time, w);
      rate(time + 1, w_next);
      const double step_s = steps_s_[group.step_of.empty() ? 0 : static_cast<std::size_t>(group.step_of[place])];
      rotation_vector(w, w_next, step_s, theta);
      const auto rotation = Rotation<double>::of<CarriedLimits::kMostDoublings>(theta);
      for (auto& row : attitude) rotation.turn<Arithmetic::kFast>(row);  // A <- A R', row by row
    }
  }
  return all;
}

void CarriedLatent::turn(const SegmentGroup& group, const std::vector<float>& attitudes, bool back, int stride,
                         std::vector<float>& signal) const {
  const int vectors = outputs_ / kAxes * stride;
  for (int v = 0; v < vectors; ++v) {
    const int row = v / stride * kAxes * stride + v % stride;
    std::array<float*, kAxes> at{};
    for (int c = 0; c < kAxes; ++c) at[static_cast<std::size_t>(c)] = signal.data() + group.at(row + c * stride, 0);
    const float* a = attitudes.data();
    for (std::size_t i = 0; i < static_cast<std::size_t>(group.length) * kGroup; ++i, a += kAxes * kAxes) {
      const float x = at[0][i], y = at[1][i], z = at[2][i];
      for (std::size_t c = 0; c < kAxes; ++c)
        at[c][i] = back ? a[c] * x + a[3 + c] * y + a[6 + c] * z : a[3 * c] * x + a[3 * c + 1] * y + a[3 * c + 2] * z;
    }
  }
}

void CarriedLatent::forward(SegmentGroup& group, int thread) {
  const std::vector<float> axes = attitudes(group);
  const std::vector<float> readings = group.readings;
  turn(group, axes, false, 1, group.readings);
  filter_.forward(group, thread);
  turn(group, axes, true, rows() / outputs_, group.latent);
  group.readings = readings;
}

void CarriedLatent::backward(SegmentGroup& group, int thread) {
  const std::vector<float> axes = attitudes(group);
  const std::vector<float> readings = group.readings, latent = group.latent;
  turn(group, axes, false, 1, group.readings);
  for (std::vector<float>* signal : {&group.latent, &group.cotangent})
    turn(group, axes, false, rows() / outputs_, *signal);
  filter_.backward(group, thread);
  group.readings = readings;
  group.latent = latent;
}

}  // namespace nlo::trainer
