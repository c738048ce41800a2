// SPDX-License-Identifier: MIT
// What the observers of a BoundStudy do: their errors without noise, with random noise and with the worst constant one,
// each run beside its bounds.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "codegen/replay/reference_observer.h"
#include "trainer/base/parallel.h"
#include "trainer/bounds/bound_study.h"
#include "trainer/data/measurement_noise.h"

namespace nlo::trainer {
namespace {

constexpr double kTransientShare = 0.1;  // "the transient is over": a tenth of the initial error is left

/// Keeps the largest error / bound; an error that is no number is beyond every bound.
void widen(double& largest, double error, double bound) {
  if (error == 0.0) return;
  const double ratio = error / bound;
  if (!(ratio <= largest)) largest = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
}

}  // namespace

BoundMeasurement BoundStudy::measure(const codegen::Model& observer, const MapConstants& map, const BoundSet& noisy,
                                     const BoundSet& quiet, double approximation) const {
  enum Kind { kQuiet, kUniform, kAbove, kBelow, kKinds };
  struct Sums {
    double squares[kKinds] = {}, largest[kKinds] = {};
    std::array<double, kBoundKinds> ratio{};
    Eigen::VectorXd quiet_squares;
  };
  const auto runs = quiet_.set.trajectories.size();
  const Eigen::Index samples = quiet_.set.trajectories.front().samples(), half = samples / 2;
  std::vector<Sums> sums(runs);
  ThreadPool pool(test_.threads);
  std::vector<std::unique_ptr<codegen::ReferenceObserver<double>>> observers(static_cast<std::size_t>(pool.threads()));
  pool.run(static_cast<int>(runs), [&](int task, int thread) {
    auto& own = observers[static_cast<std::size_t>(thread)];
    if (!own) own = std::make_unique<codegen::ReferenceObserver<double>>(observer);
    const auto i = static_cast<std::size_t>(task);
    Sums& sum = sums[i];
    for (int kind = 0; kind < kKinds; ++kind) {
      const Trajectory& truth = (kind == kQuiet ? quiet_ : disturbed_).set.trajectories[i];
      Eigen::MatrixXd y = truth.outputs;
      if (kind == kUniform) y = MeasurementNoise({NoiseKind::kUniform, test_.noise}, test_.seed, i).on(y);
      if (kind == kAbove) y.array() += test_.noise;
      if (kind == kBelow) y.array() -= test_.noise;
      const codegen::Run run = own->run(y, {}, truth.time_s, true);
      const Eigen::VectorXd error = (run.x_hat - truth.states).colwise().norm();
      const double e0 = (run.z.col(0) - map.start.col(task)).norm();
      const BoundSet& bounds = kind == kQuiet ? quiet : noisy;
      for (Eigen::Index n = 0; n < samples; ++n) {
        for (std::size_t b = 0; b < kBoundKinds; ++b) widen(sum.ratio[b], error(n), bounds[b].at(truth.time_s(n), e0));
      }
      sum.squares[kind] = error.tail(samples - half).squaredNorm();
      sum.largest[kind] = error.tail(samples - half).maxCoeff();
      if (kind == kQuiet) sum.quiet_squares = error.cwiseAbs2();
    }
  });

  const double count = static_cast<double>(runs) * static_cast<double>(samples - half);
  Eigen::VectorXd curve = Eigen::VectorXd::Zero(samples);
  double uniform = 0.0, still = 0.0;
  BoundMeasurement m;
  for (const Sums& sum : sums) {  // in the runs' order: the same bytes for any number of threads
    uniform += sum.squares[kUniform];
    still += sum.squares[kQuiet];
    curve += sum.quiet_squares;
    m.steady_max = std::max(m.steady_max, sum.largest[kUniform]);
    m.offset_max = std::max({m.offset_max, sum.largest[kAbove], sum.largest[kBelow]});
    for (std::size_t b = 0; b < kBoundKinds; ++b) m.ratio[b] = std::max(m.ratio[b], sum.ratio[b]);
  }
  m.steady_rms = std::sqrt(uniform / count);
  m.quiet_rms = std::sqrt(still / count);
  curve = (curve / static_cast<double>(runs)).cwiseSqrt();
  const auto last_above = [&](double level) -> std::optional<double> {
    Eigen::Index last = samples - 1;
    while (last > 0 && curve(last) <= level) --last;
    if (last + 1 == samples) return std::nullopt;
    return quiet_.set.trajectories.front().time_s(last);
  };
  m.transient_level = kTransientShare * curve(0) + approximation;
  m.transient_s = last_above(m.transient_level);
  m.settling_s = last_above(kTransientShare * curve(0) + m.quiet_rms);
  return m;
}

}  // namespace nlo::trainer
