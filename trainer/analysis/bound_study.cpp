// SPDX-License-Identifier: MIT
#include "trainer/analysis/bound_study.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "codegen/error.h"
#include "codegen/latent_step.h"
#include "codegen/reference_network.h"
#include "codegen/reference_observer.h"
#include "trainer/analysis/lipschitz.h"
#include "trainer/analysis/measurement_noise.h"
#include "trainer/parallel.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

constexpr Eigen::Index kSlopePoints = 600;
constexpr double kTransientShare = 0.1;  // "the transient is over": a tenth of the initial error is left

/// Every corner of the box [low, high], n x 2^n.
Eigen::MatrixXd corners(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  const Eigen::Index n = low.size(), count = Eigen::Index{1} << n;
  Eigen::MatrixXd result(n, count);
  for (Eigen::Index c = 0; c < count; ++c)
    for (Eigen::Index i = 0; i < n; ++i) result(i, c) = (c >> i & 1) != 0 ? high(i) : low(i);
  return result;
}

/// Keeps the largest error / bound; an error that is no number is beyond every bound.
void widen(double& largest, double error, double bound) {
  if (error == 0.0) return;
  const double ratio = error / bound;
  if (!(ratio <= largest)) largest = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
}

}  // namespace

const char* standing_name(Standing standing) {
  switch (standing) {
    case Standing::kProven:
      return "proven";
    case Standing::kSampled:
      return "sampled";
    case Standing::kAssumed:
      return "assumed";
  }
  return "";
}

BoundStudy::BoundStudy(const Plant& plant, const codegen::Model& model, const SimulationConfig& simulation,
                       const BoundTest& test)
    : plant_(plant),
      linear_(dynamic_cast<const LinearPlant*>(&plant)),
      model_(model),
      simulation_(simulation),
      test_(test),
      initial_(draw_initial_states(simulation, initial_state_seed(test.seed, SeedStream::kTest), test.trajectories)),
      quiet_(simulate_disturbed(plant, simulation, initial_, 0.0, test.seed)),
      disturbed_(test.disturbance > 0.0 ? simulate_disturbed(plant, simulation, initial_, test.disturbance, test.seed)
                                        : quiet_) {
  base_ = map_of(latent_system(model_));
}

MapConstants BoundStudy::map_of(const LatentSystem& system) const {
  return exact() ? exact_map_constants(*linear_, system, initial_)
                 : sampled_map_constants(plant_, system, quiet_.set, initial_);
}

/// Per output: how far the hold's input can be from h(x) between the samples.
Eigen::VectorXd BoundStudy::hold_error(const DisturbedRuns& runs, double w_bar) const {
  const bool steps = model_.hold == "zero_order";
  if (!exact()) return steps ? runs.step_error : runs.ramp_error;
  // y' = C (A x + w) and, w being held, y'' = C A (A x + w); a ramp is off by h^2/8 |y''|, a step by h |y'|.
  const double h = simulation_.sample_period_s;
  const Eigen::MatrixXd &a = linear_->a(), &c = linear_->c();
  const double norm_a = spectral_norm(a);
  double x_max = 0.0;
  for (const Trajectory& run : runs.set.trajectories) x_max = std::max(x_max, run.states.colwise().norm().maxCoeff());
  x_max = (x_max + 0.5 * h * w_bar) * std::exp(0.5 * h * norm_a);  // between two samples
  const Eigen::MatrixXd rows = steps ? c : Eigen::MatrixXd(c * a);
  return (steps ? h : h * h / 8.0) * (norm_a * x_max + w_bar) * rows.rowwise().norm();
}

/// sup |z(0) - T(x(0))| over the initial box of a linear plant (an affine map: at a corner), over the runs elsewhere.
double BoundStudy::initial_error(const codegen::Model& observer, const MapConstants& map) const {
  constexpr Eigen::Index kMostStates = 16;
  const Eigen::MatrixXd gain =
      observer.starts_steady ? codegen::steady_gain(observer) : Eigen::MatrixXd::Zero(observer.nz(), observer.ny());
  const double noise = injected_bound(gain, Eigen::VectorXd::Constant(plant_.ny(), test_.noise));
  Eigen::MatrixXd x = initial_, t = map.start;
  if (exact() && simulation_.initial_distribution == "uniform" && plant_.nx() <= kMostStates) {
    x = corners(Eigen::VectorXd::Map(simulation_.initial_low.data(), plant_.nx()),
                Eigen::VectorXd::Map(simulation_.initial_high.data(), plant_.nx()));
    t = map.matrix * x;
  }
  return ((gain * plant_.output(x) - t).colwise() + observer.initial_latent).colwise().norm().maxCoeff() + noise;
}

codegen::Model BoundStudy::exact_observer(double k) const {
  constexpr double kFar = 1e12;  // no measurement is clamped
  const LatentSystem system = scaled(latent_system(model_), k);
  codegen::Model observer = model_;
  const Eigen::Index nz = model_.nz(), ny = model_.ny(), nx = model_.nx();
  observer.eigenvalues = system.eigenvalues;
  if (observer.hold == "rk4") observer.hold = "first_order";  // whose approximation it is, with an error of its own
  observer.output_min = Eigen::VectorXd::Constant(ny, -kFar);
  observer.output_max = Eigen::VectorXd::Constant(ny, kFar);
  observer.latent_min = Eigen::VectorXd::Constant(nz, -kFar);
  observer.latent_max = Eigen::VectorXd::Constant(nz, kFar);
  codegen::Network inverse;
  inverse.features = Eigen::MatrixXd::Identity(nz, nz + ny);
  inverse.feature_mean = Eigen::VectorXd::Zero(nz);
  inverse.feature_scale = Eigen::VectorXd::Ones(nz);
  inverse.layers = {
      {map_of(system).matrix.completeOrthogonalDecomposition().pseudoInverse(), Eigen::VectorXd::Zero(nx)}};
  inverse.output_mean = Eigen::VectorXd::Zero(nx);
  inverse.output_scale = Eigen::VectorXd::Ones(nx);
  observer.inverse_map = std::move(inverse);
  return observer;
}

BoundResult BoundStudy::at(double k, const codegen::Model& observer, const std::string& inverse_map) const {
  const LatentSystem base = latent_system(model_), system = scaled(base, k);
  const MapConstants fresh = k == 1.0 ? MapConstants{} : map_of(system);
  const MapConstants& map = k == 1.0 ? base_ : fresh;
  BoundResult result;
  result.k = k;
  result.inverse_map = inverse_map;
  result.pde_residual = map.pde_residual;

  const double lambda = slowest(system);
  const Eigen::VectorXd noise = Eigen::VectorXd::Constant(plant_.ny(), test_.noise);
  const Eigen::VectorXd hold = hold_error(disturbed_, test_.disturbance), quiet_hold = hold_error(quiet_, 0.0);
  const double noise_bound = injected_bound(system.injection, noise);
  const double hold_bound = injected_bound(system.injection, hold);

  const LipschitzConstants upper = lipschitz_upper(observer);
  LipschitzConstants lower = upper;
  double approximation = 0.0;
  if (!exact()) {
    const Eigen::MatrixXd y = plant_.output(map.x);
    Eigen::MatrixXd input(map.z.rows() + y.rows(), map.z.cols());
    input << map.z, y;
    const Eigen::MatrixXd estimates = codegen::ReferenceNetwork<double>(observer.inverse_map)(input);
    approximation = (estimates - map.x).colwise().norm().maxCoeff();
    const auto thin = Eigen::seqN(0, kSlopePoints, map.x.cols() / kSlopePoints);
    lower = lipschitz_sampled(observer, map.z(Eigen::all, thin), y(Eigen::all, thin));
  }

  const Proposition2 proposition{plant_.nx(), system.nz(), slowest(base), base_.l_t, base_.l_tx};
  const auto bounds = [&](const Eigen::VectorXd& v, const Eigen::VectorXd& held, double w) {
    const double z = steady_latent_error(system, v + held, w, map.row_slopes);
    BoundSet set{bound_19(proposition, k, w, injected_bound(system.injection, v + held)),
                 {upper.latent, lambda, upper.latent * z + upper.output * v.norm() + approximation},
                 {lower.latent, lambda, lower.latent * z + lower.output * v.norm() + approximation}};
    set.paper.steady += approximation;
    return set;
  };
  result.bounds = bounds(noise, hold, test_.disturbance);
  const BoundSet quiet = bounds(Eigen::VectorXd::Zero(plant_.ny()), quiet_hold, 0.0);

  const double e0 = initial_error(observer, map);
  const Standing exactly = exact() ? Standing::kProven : Standing::kSampled;
  result.constants = {
      {"k lambda", "slowest mode of D_k [1/s]", Standing::kProven, lambda},
      {"L_T", "|x1 - x2| <= L_T |T(x1) - T(x2)| at k = 1", exactly, base_.l_t},
      {"L_Tx", "sup |dT/dx| at k = 1", exactly, base_.l_tx},
      {"L_Tk", "as L_T, of this k's own T_k", exactly, map.l_t},
      {"L_Tkx", "as L_Tx, of this k's own T_k", exactly, map.l_tx},
      {"l upper", "Lipschitz constant of T*, from its weights", Standing::kProven, upper.latent},
      {"l lower", "largest slope of T* at samples", Standing::kSampled, lower.latent},
      {"w_bar", "largest disturbance |w| of dx/dt", Standing::kAssumed, test_.disturbance},
      {"v_bar", "sup |F v| at the noise's limit", Standing::kAssumed, noise_bound},
      {"v_hold", "sup |F (held y - y)| between samples", exactly, hold_bound},
      {"eps", "approximation error of T*, sup |T*(T(x)) - x|", exactly, approximation},
      {"e0", "initial error of z, sup |z(0) - T(x(0))|", exactly, e0},
  };
  if (exact()) std::erase_if(result.constants, [](const BoundConstant& c) { return c.symbol == "l lower"; });
  if (upper.output > 0.0) {
    result.constants.push_back({"l_y upper", "as l upper, for the y that T* reads", Standing::kProven, upper.output});
    result.constants.push_back({"l_y lower", "largest slope in y at samples", Standing::kSampled, lower.output});
  }
  constexpr double kRounding = 1e-9;
  result.power_claim_holds = map.l_t <= std::pow(k, static_cast<double>(system.nz())) * base_.l_t * (1.0 + kRounding);
  result.slope_claim_holds = map.l_tx <= base_.l_tx / k * (1.0 + kRounding);
  result.l_tkx = map.l_tx;

  const double start = kTransientShare * measure(observer, map, result.bounds, quiet, result.measured);
  result.transient_paper_s = quiet.paper.transient_s(e0, start);
  result.transient_weights_s = quiet.weights.transient_s(e0, start);
  result.transient_slopes_s = quiet.slopes.transient_s(e0, start);
  return result;
}

double BoundStudy::measure(const codegen::Model& observer, const MapConstants& map, const BoundSet& noisy,
                           const BoundSet& quiet, BoundMeasurement& m) const {
  enum Kind { kQuiet, kUniform, kAbove, kBelow, kKinds };
  struct Sums {
    double squares[kKinds] = {}, largest[kKinds] = {};
    double paper = 0.0, weights = 0.0, slopes = 0.0;
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
        const double t = truth.time_s(n);
        widen(sum.paper, error(n), bounds.paper.at(t, e0));
        widen(sum.weights, error(n), bounds.weights.at(t, e0));
        widen(sum.slopes, error(n), bounds.slopes.at(t, e0));
      }
      sum.squares[kind] = error.tail(samples - half).squaredNorm();
      sum.largest[kind] = error.tail(samples - half).maxCoeff();
      if (kind == kQuiet) sum.quiet_squares = error.cwiseAbs2();
    }
  });

  const double count = static_cast<double>(runs) * static_cast<double>(samples - half);
  Eigen::VectorXd curve = Eigen::VectorXd::Zero(samples);
  double uniform = 0.0, still = 0.0;
  for (const Sums& sum : sums) {  // in the runs' order: the same bytes for any number of threads
    uniform += sum.squares[kUniform];
    still += sum.squares[kQuiet];
    curve += sum.quiet_squares;
    m.steady_max = std::max(m.steady_max, sum.largest[kUniform]);
    m.offset_max = std::max({m.offset_max, sum.largest[kAbove], sum.largest[kBelow]});
    m.ratio_paper = std::max(m.ratio_paper, sum.paper);
    m.ratio_weights = std::max(m.ratio_weights, sum.weights);
    m.ratio_slopes = std::max(m.ratio_slopes, sum.slopes);
  }
  m.steady_rms = std::sqrt(uniform / count);
  m.quiet_rms = std::sqrt(still / count);
  curve = (curve / static_cast<double>(runs)).cwiseSqrt();
  const double level = kTransientShare * curve(0) + m.quiet_rms;
  Eigen::Index last = samples;
  while (last > 0 && curve(last - 1) <= level) --last;
  if (last < samples) m.transient_s = quiet_.set.trajectories.front().time_s(last);
  return curve(0);
}

}  // namespace nlo::trainer
