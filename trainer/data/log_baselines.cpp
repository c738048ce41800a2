// SPDX-License-Identifier: MIT
#include "trainer/data/log_baselines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNotApplicable = std::numeric_limits<double>::quiet_NaN();
constexpr int kHighestDegree = 3;
constexpr std::array kWindows = {2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48};

/// Returns the measured quantity of a state as one unwrapped signal.
VectorXd measured_signal(const StateSource& source, const Trajectory& run) {
  const VectorXd output = run.outputs.row(source.output);
  if (source.cosine < 0) return source.wrap > 0.0 ? unwrap(output, source.wrap) : output;
  return unwrap(angle_of(output, run.outputs.row(source.cosine), source.wrap), source.wrap);
}

/// Estimates a state at every `stride`-th sample of the measured quantity.
VectorXd estimate_state(const StateSource& source, const EndPointPolynomial& polynomial, const VectorXd& time_s,
                        const VectorXd& signal, Index stride = 1) {
  const int derivative = source.kind == StateKind::kDerivativeOfMeasured ? 1 : 0;
  VectorXd estimate = end_point_estimate(polynomial, derivative, time_s, signal, stride);
  if (source.kind == StateKind::kSineOfMeasured) return sine_of(estimate, source.wrap);
  if (source.kind == StateKind::kCosineOfMeasured) return cosine_of(estimate, source.wrap);
  return estimate;
}

/// Returns the stride with which a long log is sampled for the choice. Without it, 48 candidates for two velocities
/// over 10^6 samples took 20 s.
Index stride_of(const Dataset& training) {
  constexpr Index kEnough = 20000;
  Index samples = 0;
  for (const Trajectory& run : training.trajectories) samples += run.samples();
  return std::max<Index>(1, samples / kEnough);
}

double squared_error(const Dataset& training, int state, const StateSource& source,
                     const EndPointPolynomial& polynomial, const std::vector<VectorXd>& signals, Index stride) {
  const double wrap = training.states[static_cast<std::size_t>(state)].wrap;
  double sum = 0.0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const Trajectory& run = training.trajectories[i];
    const VectorXd estimate = estimate_state(source, polynomial, run.time_s, signals[i], stride);
    for (Index j = 0; j < estimate.size(); ++j) {
      const double error = estimate[j] - run.states(state, j * stride);
      sum += run.weight[j * stride] * std::pow(wrap > 0.0 ? wrap_difference(error, wrap) : error, 2);
    }
  }
  return sum;
}

EndPointPolynomial best_polynomial(const Dataset& training, int state, const StateSource& source) {
  EndPointPolynomial best;
  std::vector<VectorXd> signals;
  for (const Trajectory& run : training.trajectories) signals.push_back(measured_signal(source, run));
  const Index stride = stride_of(training);
  double least = std::numeric_limits<double>::infinity();
  for (int degree = 1; degree <= kHighestDegree; ++degree)
    for (const int samples : kWindows) {
      if (samples <= degree) continue;
      const EndPointPolynomial candidate{samples, degree};
      const double error = squared_error(training, state, source, candidate, signals, stride);
      if (error < least) least = error, best = candidate;
    }
  return best;
}

/// Returns the best_sensor() of a state on the logs.
int sensor_of(const Dataset& training, int state) {
  const Channel& wanted = training.states[static_cast<std::size_t>(state)];
  const auto error_of = [&](const auto& estimate) {
    double squares = 0.0;
    for (const Trajectory& run : training.trajectories)
      for (Index k = 0; k < run.samples(); ++k) {
        if (run.weight[k] <= 0.0) continue;
        const double error = run.states(state, k) - estimate(run, k);
        squares += run.weight[k] * std::pow(wanted.wrap > 0.0 ? wrap_difference(error, wanted.wrap) : error, 2);
      }
    return std::sqrt(squares);
  };
  std::vector<double> errors;
  for (Index j = 0; j < codegen::measured_outputs(training.outputs); ++j) {
    const bool measures = !wanted.unit.empty() && training.outputs[static_cast<std::size_t>(j)].unit == wanted.unit;
    errors.push_back(measures ? error_of([j](const Trajectory& run, Index k) { return run.outputs(j, k); })
                              : std::numeric_limits<double>::infinity());
  }
  const double mean = mean_states(training)[state];
  return best_sensor(errors, error_of([mean](const Trajectory&, Index) { return mean; }));
}

}  // namespace

VectorXd end_point_estimate(const EndPointPolynomial& polynomial, int derivative, const VectorXd& time_s,
                            const VectorXd& measured, Index stride) {
  using Powers = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 64, kHighestDegree + 1>;
  VectorXd estimate((measured.size() + stride - 1) / stride);
  for (Index at = 0; at < estimate.size(); ++at) {
    const Index k = at * stride;
    const Index n = std::min<Index>(k + 1, polynomial.samples);
    const Index terms = std::min<Index>(polynomial.degree + 1, n);
    if (terms <= derivative) {
      estimate[at] = 0.0;
      continue;
    }
    // Time runs from -1 to 0 over the window and the newest measurement is zero, so that the normal equations are well
    // conditioned at these degrees.
    const double span_s = n > 1 ? time_s[k] - time_s[k - n + 1] : 1.0;
    const auto t = (time_s.segment(k - n + 1, n).array() - time_s[k]) / span_s;
    Powers powers(n, terms);
    powers.col(0).setOnes();
    for (Index i = 1; i < terms; ++i) powers.col(i) = powers.col(i - 1).array() * t;
    const auto y = measured.segment(k - n + 1, n).array() - measured[k];
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kHighestDegree + 1, 1> coefficients =
        (powers.transpose() * powers).ldlt().solve(powers.transpose() * y.matrix());
    estimate[at] = derivative == 0 ? measured[k] + coefficients[0] : coefficients[1] / span_s;
  }
  return estimate;
}

VectorXd mean_states(const Dataset& dataset) {
  VectorXd mean = VectorXd::Zero(static_cast<Index>(dataset.states.size()));
  for (Index i = 0; i < mean.size(); ++i) {
    const double wrap = dataset.states[static_cast<std::size_t>(i)].wrap;
    double sum = 0.0, sine = 0.0, cosine = 0.0, weight = 0.0;
    for (const Trajectory& run : dataset.trajectories) {
      const VectorXd state = run.states.row(i);
      const VectorXd sines = wrap > 0.0 ? sine_of(state, wrap) : state;
      const VectorXd cosines = wrap > 0.0 ? cosine_of(state, wrap) : state;
      for (Index k = 0; k < run.samples(); ++k) {
        if (run.weight[k] <= 0.0) continue;  // masked truth may have any value
        sum += run.weight[k] * state[k];
        sine += run.weight[k] * sines[k];
        cosine += run.weight[k] * cosines[k];
        weight += run.weight[k];
      }
    }
    if (weight > 0.0) mean[i] = sum / weight;
    if (wrap > 0.0) mean[i] = angle_of(VectorXd::Constant(1, sine), VectorXd::Constant(1, cosine), wrap)[0];
  }
  return mean;
}

int best_sensor(const std::vector<double>& errors, double deviation) {
  constexpr double kExact = 1e-5;
  const auto least = std::min_element(errors.begin(), errors.end());
  const bool none = least == errors.end() || !(*least < deviation) || *least <= kExact * deviation;
  return none ? -1 : static_cast<int>(least - errors.begin());
}

const std::vector<std::string>& LogBaseline::names() {
  static const std::vector<std::string> names = {"constant", "sensor", "difference", "polynomial", "static_ridge"};
  return names;
}

LogBaseline LogBaseline::fit(std::string_view name, const Dataset& training, const std::vector<StateSource>& sources) {
  if (std::find(names().begin(), names().end(), name) == names().end())
    throw codegen::Error(fmt::format("no baseline \"{}\": expected one of {}", name, fmt::join(names(), ", ")));
  LogBaseline baseline;
  baseline.name_ = name;
  baseline.sources_ = sources;
  baseline.mean_ = mean_states(training);
  if (name == "constant") return baseline;
  if (name == "static_ridge") {
    baseline.ridge_ = StaticRidge::fit(training);
    return baseline;
  }
  if (name == "sensor") {
    for (int i = 0; i < static_cast<int>(training.states.size()); ++i) {
      baseline.sensors_.push_back(sensor_of(training, i));
      baseline.sensor_names_.push_back(baseline.sensors_.back() < 0
                                           ? ""
                                           : training.outputs[static_cast<std::size_t>(baseline.sensors_.back())].name);
    }
    return baseline;
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const bool choose = name == "polynomial" && sources[i].kind != StateKind::kHidden;
    const int state = static_cast<int>(i);
    baseline.polynomials_.push_back(choose ? best_polynomial(training, state, sources[i]) : EndPointPolynomial{});
  }
  return baseline;
}

bool LogBaseline::applies(int state) const {
  if (!sensors_.empty()) return sensors_[static_cast<std::size_t>(state)] >= 0;
  return polynomials_.empty() || sources_[static_cast<std::size_t>(state)].kind != StateKind::kHidden;
}

Index LogBaseline::multiply_adds() const {
  return ridge_ ? ridge_->features() * (1 + 2 * static_cast<Index>(sources_.size())) : 0;
}

std::string LogBaseline::describe(int state) const {
  if (ridge_)
    return fmt::format("static ridge ({} features: the last 3 samples and their products)", ridge_->features());
  if (!sensors_.empty() && applies(state))
    return "output " + sensor_names_[static_cast<std::size_t>(state)] + " as it is";
  if (name_ != "polynomial" || !applies(state)) return name_;
  const EndPointPolynomial& chosen = polynomials_[static_cast<std::size_t>(state)];
  return fmt::format("polynomial (degree {}, {} samples)", chosen.degree, chosen.samples);
}

MatrixXd LogBaseline::estimate(const Trajectory& run) const {
  if (ridge_) return ridge_->estimate(run);
  MatrixXd estimates = mean_.replicate(1, run.samples());
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    if (sensors_[i] >= 0)
      estimates.row(row) = run.outputs.row(sensors_[i]);
    else
      estimates.row(row).setConstant(kNotApplicable);
  }
  if (polynomials_.empty()) return estimates;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    if (applies(static_cast<int>(i)))
      estimates.row(row) =
          estimate_state(sources_[i], polynomials_[i], run.time_s, measured_signal(sources_[i], run)).transpose();
    else
      estimates.row(row).setConstant(kNotApplicable);
  }
  return estimates;
}

}  // namespace nlo::trainer
