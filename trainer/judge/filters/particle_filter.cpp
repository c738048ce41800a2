// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/particle_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "trainer/base/noise_table.h"
#include "trainer/data/angle.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/run_random.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kForABias = 3;    // factor on the number of particles, because a bias is one more state
constexpr double kKernel = 0.15;  // sqrt(1 - a^2)

/// Returns p(v) of the noise without outliers and quantisation.
ArrayXd base_density(const SensorNoise& noise, const ArrayXd& v) {
  return noise_row(noise.kind).density(v / noise.scale, noise.shape) / noise.scale;
}

/// The particles of one run. Rows: the states of the plant, then a bias for each output that has one.
class Cloud {
 public:
  Cloud(const SimulationConfig& simulation, double box_scale, const NoiseConfig& noise, Index nx, Index ny,
        const ParticleSettings& settings, std::uint64_t run)
      : random_(settings.seed, RunPurpose::kParticles, 0, run), nx_(nx) {
    const bool biased = std::any_of(noise.sensors.begin(), noise.sensors.end(),
                                    [](const SensorNoise& sensor) { return sensor.bias > 0.0; });
    const Index count = settings.particles * (biased ? kForABias : 1);
    const MatrixXd start =
        draw_initial_states(simulation, settings.seed + 0x9e3779b97f4a7c15ULL * (run + 1), count, box_scale);
    x_ = MatrixXd::Zero(nx + ny, count);
    x_.topRows(nx) = start;
    for (Index j = 0; j < ny; ++j)
      for (Index i = 0; i < count; ++i) {
        const double bias = noise.of(static_cast<std::size_t>(j)).bias;
        if (bias > 0.0) x_(nx + j, i) = random_.between(-bias, bias);
      }
    log_weight_ = ArrayXd::Zero(count);
  }

  void move(const LanePlant& plant, const LaneRuns& run, Index k, const std::vector<double>& process_noise) {
    LaneInputs u = inputs_before(run, k);
    u.from = u.from.replicate(1, x_.cols()).eval();
    u.to = u.to.replicate(1, x_.cols()).eval();
    x_.topRows(nx_) = advance(plant, x_.topRows(nx_), run.step_s(k), u);
    for (std::size_t i = 0; i < process_noise.size(); ++i) {
      const double deviation = process_noise[i] * std::sqrt(run.step_s(k));
      if (deviation == 0.0) continue;
      for (double& value : x_.row(static_cast<Index>(i))) value += deviation * random_.normal();
    }
    drop_escaped();
  }

  /// Applies Bayes' rule in powers of the likelihood that leave at least half of the particles (Musso, Oudjane, Le
  /// Gland in: Doucet et al., chapter 12). Between them the particles are resampled where the likelihood is large.
  void weigh(const LanePlant& plant, const NoiseConfig& noise, const VectorXd& y, const MatrixXd& u) {
    constexpr int kMostPieces = 50;
    double rest = 1.0;
    for (int piece = 0; piece < kMostPieces && rest > 0.0; ++piece) {
      const ArrayXd log_p = log_likelihood_of_all(plant, noise, y, u);
      double share = rest;
      const auto weights = [&] {
        const ArrayXd log_w = log_weight_ + share * log_p;
        const ArrayXd w = (log_w - log_w.maxCoeff()).exp();
        return ArrayXd(w / w.sum());
      };
      weight_ = weights();
      while (are_few() && share > 1e-3 * rest && piece + 1 < kMostPieces) {
        share *= 0.5;
        weight_ = weights();
      }
      log_weight_ = weight_.max(1e-300).log();
      rest = share < rest ? rest - share : 0.0;
      if (rest > 0.0 || are_few()) resample();
    }
  }

  VectorXd mean() const { return x_ * weight_.matrix(); }

 private:
  ArrayXd log_likelihood_of_all(const LanePlant& plant, const NoiseConfig& noise, const VectorXd& y,
                                const MatrixXd& u) const {
    const MatrixXd seen = output_at(plant, x_.topRows(nx_), u);
    ArrayXd sum = ArrayXd::Zero(x_.cols());
    for (Index j = 0; j < plant.ny; ++j) {
      if (std::isnan(y[j])) continue;
      ArrayXd error = y[j] - seen.row(j).transpose().array() - x_.row(nx_ + j).transpose().array();
      const double wrap = plant.output_wraps[j];
      if (wrap > 0.0) error = error.unaryExpr([wrap](double v) { return wrap_difference(v, wrap); }).eval();
      sum += log_likelihood(noise.of(static_cast<std::size_t>(j)), error);
    }
    return sum;
  }

  /// Removes particles that overflow: such a particle gets the state of a valid one and almost no weight.
  void drop_escaped() {
    constexpr double kEscaped = 1e9;  // limit at which simulations stop
    const auto inside = (x_.array().abs() <= kEscaped).colwise().all().eval();
    Index kept = 0;
    if (inside.all() || !inside.maxCoeff(&kept)) return;
    for (Index i = 0; i < x_.cols(); ++i) {
      if (inside[i]) continue;
      x_.col(i) = x_.col(kept);
      log_weight_[i] = -700.0;  // e^-700 is near the smallest double
    }
  }

  bool are_few() const { return weight_.square().sum() * static_cast<double>(x_.cols()) > 2.0; }

  void resample() {
    const Index count = x_.cols();
    const VectorXd centre = mean();
    const MatrixXd off = x_.colwise() - centre;
    MatrixXd covariance = off * weight_.matrix().asDiagonal() * off.transpose();
    covariance.diagonal().array() += 1e-16;
    const MatrixXd root = Eigen::LLT<MatrixXd>(covariance).matrixL();
    const double kept = std::sqrt(1.0 - kKernel * kKernel);
    MatrixXd drawn(x_.rows(), count);
    const double first = random_.uniform();
    double sum = weight_[0];
    VectorXd normal(x_.rows());
    for (Index i = 0, from = 0; i < count; ++i) {
      const double wanted = (static_cast<double>(i) + first) / static_cast<double>(count);
      while (sum < wanted && from + 1 < count) sum += weight_[++from];
      for (double& value : normal) value = random_.normal();
      drawn.col(i) = centre + kept * (x_.col(from) - centre) + kKernel * (root * normal);
    }
    x_ = drawn;
    log_weight_.setZero();
    weight_.setConstant(1.0 / static_cast<double>(count));
  }

  RunRandom random_;
  Index nx_;
  MatrixXd x_;
  ArrayXd log_weight_, weight_;
};

}  // namespace

std::string no_likelihood(const NoiseConfig& noise) {
  for (const SensorNoise& sensor : noise.sensors) {
    if (sensor.shifted()) return "with a delay, the likelihood of the present state is unknown";
    if (sensor.lies() || sensor.common_bias > 0.0)
      return "this filter has no likelihood for stuck or dead sensors and common biases";
    if (noise_row(sensor.kind).density == nullptr && sensor.quantum == 0.0)
      return "an output has no noise, so the smallest possible error is 0";
  }
  return "";
}

ArrayXd log_likelihood(const SensorNoise& noise, const ArrayXd& v) {
  constexpr double kLeast = 1e-30;  // a particle with almost no weight stays finite
  ArrayXd density = ArrayXd::Zero(v.size());
  if (noise.quantum > 0.0 && noise_row(noise.kind).density == nullptr) {
    density = soft_box(v, 0.5 * noise.quantum) / noise.quantum;
  } else if (noise.quantum > 0.0) {
    constexpr int kPoints = 5;  // points of the step, by the midpoint rule
    for (int p = 0; p < kPoints; ++p)
      density += base_density(noise, v + noise.quantum * ((p + 0.5) / kPoints - 0.5)) / kPoints;
  } else {
    density = base_density(noise, v);
  }
  if (noise.outlier_share > 0.0 && noise.outlier_amplitude > 0.0)
    density = (1.0 - noise.outlier_share) * density +
              noise.outlier_share * soft_box(v, noise.outlier_amplitude) / (2.0 * noise.outlier_amplitude);
  return (density + kLeast).log();
}

MatrixXd particle_estimates(const LanePlant& plant, const SimulationConfig& simulation, double box_scale,
                            const NoiseConfig& noise, const LaneRuns& run, const ParticleSettings& settings,
                            std::uint64_t run_number) {
  Cloud cloud(simulation, box_scale, noise, plant.nx, plant.ny, settings, run_number);
  MatrixXd estimates(plant.nx, run.samples());
  for (Index k = 0; k < run.samples(); ++k) {
    if (k > 0) cloud.move(plant, run, k, simulation.process_noise);
    cloud.weigh(plant, noise, run.outputs[static_cast<std::size_t>(k)].col(0), run.inputs_at(k));
    estimates.col(k) = cloud.mean().head(plant.nx);
  }
  return estimates;
}

}  // namespace nlo::trainer
