// SPDX-License-Identifier: MIT
#include "codegen/replay/export_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "codegen/model/domain.h"
#include "codegen/model/field_checks.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kWanted = 10000;  // samples in the domain; ten of them are above the 99.9 % quantile
constexpr int kFewest = 1000;   // one of these is above the quantile
constexpr int kToneSamples = 1000;
constexpr int kMostToneRuns = 40;

/// Returns the readings of the sensors in a recorded run.
ReplayInputs measured(const Flight& flight, const FlightRun& run) {
  ReplayInputs inputs{VectorXd::Zero(run.outputs.cols()), flight.output_step.asDiagonal() * run.outputs.cast<double>(),
                      flight.input_step.asDiagonal() * run.inputs.cast<double>()};
  if (run.inputs.size() == 0) inputs.inputs.resize(0, run.outputs.cols());
  if (run.dt.size() == 0) return inputs;
  inputs.dt_s = flight.dt_step_s * run.dt.cast<double>();
  inputs.dt_s(0) = 0.0;  // there is no earlier sample
  return inputs;
}

/// Returns readings (n_r x 2: low, high) for which the steady state z = S y of a KKL observer is in its domain, or
/// nearly. If the domain does not limit the readings, returns the declared ranges.
MatrixXd resting_ranges(const Model& m, const FoldedModel& folded) {
  const VectorXd low = reading_min(m), high = reading_max(m);
  MatrixXd ranges(m.nr(), 2);
  ranges << low, high;
  const VectorXd half_z = (m.latent_max - m.latent_min) / 2.0, middle_z = (m.latent_max + m.latent_min) / 2.0;
  const VectorXd half_y = (high - low) / 2.0, middle_y = (high + low) / 2.0;
  MatrixXd gain = folded.steady_gain;
  for (int j = 0; j < m.nr(); ++j)
    if (is_relative(m, j)) gain.col(j).setZero();  // its domain moves with the output
  // Least squares in units of the domain. If no latent state depends on an output, its centre does not change.
  const MatrixXd scaled = half_z.cwiseInverse().asDiagonal() * gain * half_y.asDiagonal();
  if (scaled.isZero(0.0)) return ranges;
  const VectorXd off = (middle_z - gain * middle_y).cwiseQuotient(half_z);
  const VectorXd shift = least_squares(scaled, off).col(0).cwiseMax(-1.0).cwiseMin(1.0);
  const double share = std::min(1.0, 1.0 / scaled.cwiseAbs().rowwise().sum().maxCoeff());
  for (int j = 0; j < m.nr(); ++j) {
    if (scaled.col(j).isZero(0.0)) continue;
    ranges(j, 0) = std::max(middle_y(j) + (shift(j) - share) * half_y(j), low(j));
    ranges(j, 1) = std::min(middle_y(j) + (shift(j) + share) * half_y(j), high(j));
  }
  return ranges;
}

/// Rounds to float, so that both sides get the same measurements for any scalar.
MatrixXd in_float(const MatrixXd& values) {
  return values.cast<float>().cast<double>();
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  const auto size = static_cast<double>(values.size());
  constexpr double kRounding = 1e-9;  // 0.999 times 11,000 is slightly above 10,989
  const auto rank = static_cast<std::size_t>(std::clamp(std::ceil(p * size - kRounding), 1.0, size));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

ErrorReplay::ErrorReplay(const Model& m, const FoldedModel& plain) : model_(m), steady_gain_(plain.steady_gain) {
  for (const FlightRun& run : m.flight.runs) add(measured(m.flight, run));
  recorded_ = samples_;

  std::uint64_t seed = 1;
  add(replay_inputs(m, plain.stale_after, seed, kToneSamples));
  const MatrixXd ranges = resting_ranges(m, plain);
  constexpr double kSmallest = 1.0 / 64.0;
  double amplitude = 1.0;
  for (int run = 0; run < kMostToneRuns && samples_ < kWanted; ++run) {
    const int before = samples_;
    add(replay_inputs(m, plain.stale_after, ++seed, kToneSamples, amplitude, ranges));
    if (2 * (samples_ - before) < kToneSamples) amplitude = std::max(amplitude / 2.0, kSmallest);
  }
  if (samples_ >= kFewest) return;
  Index all = 0;
  for (const ReplayInputs& run : runs_) all += run.dt_s.size();
  fail(
      "only {} of {} replayed samples lie in the domain of \"{}\", but the error needs at least {}; train again, "
      "because training records flights in the model file, or, if the model is made by hand, widen latent_min and "
      "latent_max",
      samples_, all, m.name, kFewest);
}

void ErrorReplay::add(ReplayInputs inputs) {
  inputs.dt_s = in_float(inputs.dt_s);
  inputs.outputs = in_float(inputs.outputs);
  inputs.inputs = in_float(inputs.inputs);
  const Index samples = inputs.dt_s.size();
  ReferenceObserver<double> exact(model_);
  MatrixXd z(model_.nz(), samples), y(model_.nr(), samples), turned(model_.nr(), samples);
  std::vector<bool> inside;
  for (Index k = 0; k < samples; ++k) {
    const double dt_s = inputs.dt_s(k) == 0.0 ? model_.sample_period_s : inputs.dt_s(k);
    exact.step(inputs.outputs.col(k), inputs.inputs.col(k), dt_s);
    turned.col(k) = turns_in(model_, exact.output());
    y.col(k) = exact.output() - turned.col(k);
    z.col(k) = exact.latent();
    inside.push_back(exact.in_domain());
  }
  z -= steady_gain_ * turned;
  samples_ += static_cast<int>(std::count(inside.begin(), inside.end(), true));
  x_hat_.push_back(exact.estimates(z, y));
  y_.push_back(std::move(y));
  turned_.push_back(std::move(turned));
  in_domain_.push_back(std::move(inside));
  runs_.push_back(std::move(inputs));
}

ExportError ErrorReplay::error(const FoldedModel& folded, const QuantisedModel* quantised, ScalarType scalar) const {
  const Index nx = model_.nx();
  ExportError error{VectorXd::Zero(nx), VectorXd::Zero(nx), VectorXd::Zero(nx), VectorXd::Zero(nx)};
  error.samples = samples_;
  error.recorded = recorded_;
  std::vector<std::vector<double>> inside(static_cast<std::size_t>(nx));
  ExportedObserver exported(model_, folded, quantised, scalar);
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const ReplayInputs& inputs = runs_[r];
    const Index samples = inputs.dt_s.size();
    exported.reset();
    MatrixXd z(model_.nz(), samples);
    for (Index k = 0; k < samples; ++k) {
      const double dt_s = inputs.dt_s(k) == 0.0 ? model_.sample_period_s : inputs.dt_s(k);
      exported.step(inputs.outputs.col(k), inputs.inputs.col(k), dt_s);
      z.col(k) = exported.latent();
    }
    z -= folded.steady_gain * turned_[r];
    const MatrixXd off = (exported.estimates(z, y_[r]) - x_hat_[r]).cwiseAbs();
    for (Index k = 0; k < samples; ++k) {
      const bool counts = in_domain_[r][static_cast<std::size_t>(k)];
      error.outside += counts ? 0 : 1;
      VectorXd& largest = counts ? error.max : error.max_outside;
      largest = largest.cwiseMax(off.col(k));
      if (!counts) continue;
      error.rms += off.col(k).cwiseAbs2();
      for (Index i = 0; i < nx; ++i) inside[static_cast<std::size_t>(i)].push_back(off(i, k));
    }
  }
  error.rms = (error.rms / error.samples).cwiseSqrt();
  for (Index i = 0; i < nx; ++i) error.quantile999(i) = quantile(std::move(inside[static_cast<std::size_t>(i)]), 0.999);
  return error;
}

}  // namespace nlo::codegen
