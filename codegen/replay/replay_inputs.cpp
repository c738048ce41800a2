// SPDX-License-Identifier: MIT
#include "codegen/replay/replay_inputs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/splitmix.h"
#include "codegen/fold/fold.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/structures/prior_dynamics.h"

namespace nlo::codegen {
namespace {

/// Random numbers in [0, 1) that are the same on every platform.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}

  double operator()() { return static_cast<double>(splitmix64(state_) >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

/// Sums of six tones, with periods from the whole replay to 12 samples; |sum| <= 1.
Eigen::VectorXd tones(const Eigen::VectorXd& time_s, double sample_period_s, Uniform& uniform) {
  constexpr int kTones = 6;
  const double longest_s = static_cast<double>(time_s.size()) * sample_period_s, shortest_s = 12.0 * sample_period_s;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(time_s.size());
  for (int i = 0; i < kTones; ++i) {
    const double period_s = shortest_s * std::pow(std::max(longest_s / shortest_s, 1.0), uniform());
    const double phase = 2.0 * std::numbers::pi * uniform();
    for (Eigen::Index k = 0; k < sum.size(); ++k)
      sum(k) += std::sin(2.0 * std::numbers::pi * time_s(k) / period_s + phase) / kTones;
  }
  return sum;
}

/// Returns `angle` without whole turns, in [low, low + turn). It keeps a distance from the wrap and from half a turn,
/// so that rounding cannot change the side.
double measured_angle(double angle, double low, double turn) {
  constexpr double kMargin = 0.01;
  for (const double edge : {low, turn / 2.0}) {
    const double off = std::remainder(angle - edge, turn);
    if (std::abs(off) < kMargin * turn) angle += kMargin * turn - off;
  }
  return angle - turn * std::floor((angle - low) / turn);
}

/// Returns the length of a step [sample periods]. Lengths near 1.5 are left out, because rounding could then change the
/// number of pieces into which the observer splits the step.
double irregular_step(Uniform& uniform) {
  const double step = 0.4 + 1.6 * uniform();
  return std::abs(step - 1.5) < 1e-3 ? 1.49 : step;
}

/// Replaces sound readings of a model with known equations by outputs of these equations, driven by the inputs, plus as
/// much noise as its filter expects. Where the plant leaves the model's ranges, it starts again.
void follow_equations(const Model& m, ReplayInputs& inputs) {
  constexpr double kDeviations = 3.0;  // span of the added noise, in standard deviations that the filter expects
  const Equations equations = prior_equations(m);
  const auto& own = own_part<Prior>(m);
  const Eigen::Index carried = equations.carried(), states = equations.nx();
  Eigen::VectorXd start = Eigen::VectorXd::Zero(carried), u = Eigen::VectorXd::Zero(m.nu());
  start.head(states) = m.initial_latent.tail(carried).head(states);
  Eigen::VectorXd x = start, y(m.ny() * (1 + states));
  const auto is_within = [](const auto& values, const auto& low, const auto& high) {
    return (values.array() >= low.array()).all() && (values.array() <= high.array()).all();
  };
  for (Eigen::Index k = 0; k < inputs.dt_s.size(); ++k) {
    for (Eigen::Index j = 0; j < u.size(); ++j)
      if (std::isfinite(inputs.inputs(j, k))) u(j) = inputs.inputs(j, k);
    const double dt_s = inputs.dt_s(k) == 0.0 ? m.sample_period_s : inputs.dt_s(k);
    const int pieces = k == 0 ? 0 : pieces_of(dt_s, m.sample_period_s);
    for (int piece = 0; piece < pieces; ++piece)
      equations.step(x.data(), dt_s / pieces, [&u](double, double* to) { std::copy(u.begin(), u.end(), to); });
    equations.output(x.data(), u.data(), y.data());
    if (!is_within(x.head(states), own.state_min.head(states), own.state_max.head(states)) ||
        !is_within(y.head(m.ny()), m.output_min, m.output_max)) {
      x = start;
      equations.output(x.data(), u.data(), y.data());
    }
    for (Eigen::Index j = 0; j < m.ny(); ++j) {
      double& reading = inputs.outputs(j, k);
      const double low = m.output_min(j), high = m.output_max(j), tone = (reading - (low + high) / 2.0) / (high - low);
      if (std::isfinite(reading) && reading <= high)  // it is no fault
        reading = std::clamp(y(j) + kDeviations * std::sqrt(own.output_noise(j)) * tone, low, high);
    }
  }
}

}  // namespace

ReplayInputs replay_inputs(const Model& m, int stale_after, std::uint64_t seed, int samples, double amplitude,
                           const Eigen::MatrixXd& ranges, bool turns_relative, bool follows_equations) {
  Uniform uniform(seed);
  const double h = m.sample_period_s;
  ReplayInputs inputs{Eigen::VectorXd::Zero(samples), Eigen::MatrixXd(m.ny(), samples),
                      Eigen::MatrixXd(m.nu(), samples)};
  Eigen::VectorXd time_s(samples);
  for (int k = 0; k < samples; ++k) {
    const bool irregular = k >= samples / 2 && k < samples * 7 / 10;
    if (irregular && k > 0) inputs.dt_s(k) = h * irregular_step(uniform);
    time_s(k) = k == 0 ? 0.0 : time_s(k - 1) + (irregular ? inputs.dt_s(k) : h);
  }

  for (int j = 0; j < m.ny(); ++j) {
    const double low = m.output_min(j), high = m.output_max(j), wrap = m.outputs[static_cast<std::size_t>(j)].wrap;
    const bool turns = wrap > 0.0 && high - low >= wrap * (1.0 - 1e-6);
    const bool narrowed = ranges.size() != 0 && !turns;
    const double from = narrowed ? ranges(j, 0) : low, to = narrowed ? ranges(j, 1) : high;
    const Eigen::VectorXd tone = tones(time_s, h, uniform);
    for (int k = 0; k < samples; ++k) {
      double y = (from + to) / 2.0 + (turns ? 1.0 : amplitude) * 0.85 * (to - from) / 2.0 * tone(k);
      if (turns) y = measured_angle(y + 2.5 * wrap * k / samples, low, wrap);
      // Two jumps of less than W / 2 each; after them z has turned back.
      if (turns_relative) y += 0.4 * relative_wrap(m, j) * ((k >= samples * 9 / 20) + (k >= samples * 6 / 10));
      inputs.outputs(j, k) = y;
    }
  }

  constexpr double kMissedShare = 0.03, kOutsideShare = 0.02;
  const double missed = std::numeric_limits<double>::quiet_NaN();
  for (int k = 10; k < samples; ++k) {
    const int j = static_cast<int>(uniform() * m.measured());
    const double kind = uniform();
    if (kind < kMissedShare) {
      inputs.outputs(j, k) = missed;
    } else if (kind < kMissedShare + kOutsideShare) {
      // A few wraps W do not change a relative output. Sometimes it is outside of the accepted range.
      const double wrap = relative_wrap(m, j);
      double& y = inputs.outputs(j, k);
      if (wrap > 0.0)
        y = k % 4 == 0 ? 70.0 * wrap : y + wrap * (1 + k % 3);
      else
        y = m.output_max(j) + 0.5 * (m.output_max(j) - m.output_min(j));
    }
  }
  const std::vector<int> slow = not_due(m);
  for (int j = 0; j < m.measured(); ++j)  // a slow output arrives when it is due, and once it is late
    for (int k = 0; slow[static_cast<std::size_t>(j)] > 0 && k < samples; ++k) {
      const int period = slow[static_cast<std::size_t>(j)] + 1;
      const bool late = k >= samples / 4 && k < samples / 4 + 2 * period + stale_after;
      if (k % period != 0 || late) inputs.outputs(j, k) = missed;
    }
  for (int i = 0; i < m.nu(); ++i) {
    const Eigen::VectorXd tone = amplitude * tones(time_s, h, uniform);
    inputs.inputs.row(i) = tone;
    if (!m.inputs.empty()) {  // the observer reads them, so their ranges are known
      const int j = m.ny() + i;
      const double from = ranges.size() != 0 ? ranges(j, 0) : m.input_min(i);
      const double to = ranges.size() != 0 ? ranges(j, 1) : m.input_max(i);
      inputs.inputs.row(i) = ((from + to) / 2.0 + 0.85 * (to - from) / 2.0 * tone.array()).matrix();
    }
    inputs.inputs(i, samples / 3) = missed;
  }
  if (follows_equations) follow_equations(m, inputs);
  const int gap = std::min(stale_after + 2, samples / 8);
  for (int k = samples * 8 / 10; k < samples * 8 / 10 + gap; ++k) inputs.outputs.col(k).setConstant(missed);
  return inputs;
}

}  // namespace nlo::codegen
