// SPDX-License-Identifier: MIT
#include "trainer/bounds/bound_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "codegen/model/latent_step.h"
#include "codegen/reference/network.h"
#include "trainer/bounds/lipschitz.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

constexpr Eigen::Index kSlopePoints = 600;
constexpr Eigen::Index kMostCorners = 16;  // 2^16 of them

/// Every corner of the box [low, high], n x 2^n.
Eigen::MatrixXd corners(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  const Eigen::Index n = low.size(), count = Eigen::Index{1} << n;
  Eigen::MatrixXd result(n, count);
  for (Eigen::Index c = 0; c < count; ++c)
    for (Eigen::Index i = 0; i < n; ++i) result(i, c) = (c >> i & 1) != 0 ? high(i) : low(i);
  return result;
}

/// Of the plant's own class, or from its values at `initial`'s size.
Linearity linearity_of(const Plant& plant, const Eigen::MatrixXd& initial) {
  if (dynamic_cast<const LinearPlant*>(&plant) != nullptr) return {};
  const Eigen::VectorXd size = initial.cwiseAbs().rowwise().maxCoeff();
  return recognise_linear(plant, size.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; }));
}

}  // namespace

const char* evidence_name(Evidence evidence) {
  switch (evidence) {
    case Evidence::kProven:
      return "proven";
    case Evidence::kSampled:
      return "sampled";
    case Evidence::kAssumed:
      return "assumed";
  }
  return "";
}

BoundStudy::BoundStudy(const Plant& plant, const codegen::Model& model, const SimulationConfig& simulation,
                       const BoundTest& test)
    : plant_(plant),
      model_(model),
      simulation_(simulation),
      test_(test),
      initial_(draw_initial_states(simulation, initial_state_seed(test.seed, SeedStream::kTest), test.trajectories)),
      recognised_(linearity_of(plant, initial_)),
      linear_(recognised_.plant ? recognised_.plant.get() : dynamic_cast<const LinearPlant*>(&plant)),
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
  const bool steps = model_.hold == Hold::kZeroOrder;
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

/// On a linear plant: z(0) - T(x(0)) is largest at a corner.
bool BoundStudy::starts_are_in_a_box() const {
  return exact() && simulation_.initial_distribution == InitialDistribution::kUniform && plant_.nx() <= kMostCorners;
}

/// sup |z(0) - T(x(0))| over the initial box where that is known, else the largest over the runs.
double BoundStudy::initial_error(const codegen::Model& observer, const MapConstants& map) const {
  const Eigen::MatrixXd gain = codegen::linear_latent(observer)->starts_steady
                                   ? codegen::steady_gain(observer)
                                   : Eigen::MatrixXd::Zero(observer.nz(), observer.ny());
  const double noise = injected_bound(gain, Eigen::VectorXd::Constant(plant_.ny(), test_.noise));
  Eigen::MatrixXd x = initial_, t = map.start;
  if (starts_are_in_a_box()) {
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
  codegen::linear_latent(observer)->eigenvalues = system.eigenvalues;
  if (observer.hold == Hold::kRk4)
    observer.hold = Hold::kFirstOrder;  // whose approximation it is, with an error of its own
  observer.output_min = Eigen::VectorXd::Constant(ny, -kFar);
  observer.output_max = Eigen::VectorXd::Constant(ny, kFar);
  observer.latent_min = Eigen::VectorXd::Constant(nz, -kFar);
  observer.latent_max = Eigen::VectorXd::Constant(nz, kFar);
  codegen::Network inverse;
  inverse.features = Eigen::MatrixXd::Identity(nz, nz + ny);
  inverse.feature_mean = Eigen::VectorXd::Zero(nz);
  inverse.feature_scale = Eigen::VectorXd::Ones(nz);
  inverse.layers = {{codegen::pseudo_inverse(map_of(system).matrix), Eigen::VectorXd::Zero(nx)}};
  inverse.output_mean = Eigen::VectorXd::Zero(nx);
  inverse.output_scale = Eigen::VectorXd::Ones(nx);
  *codegen::inverse_map(observer) = std::move(inverse);
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
  LipschitzConstants lower = upper, box = upper;
  double approximation = 0.0, steepest = 0.0;
  if (!exact()) {
    const Eigen::MatrixXd y = plant_.output(map.x);
    Eigen::MatrixXd input(map.z.rows() + y.rows(), map.z.cols());
    input << map.z, y;
    const Eigen::MatrixXd estimates = codegen::ReferenceNetwork<double>(*codegen::inverse_map(observer))(input);
    approximation = (estimates - map.x).colwise().norm().maxCoeff();
    const auto thin = Eigen::seqN(0, kSlopePoints, map.x.cols() / kSlopePoints);
    lower = lipschitz_sampled(observer, map.z(Eigen::all, thin), y(Eigen::all, thin));
    LocalLipschitzOptions options;
    options.boxes = test_.boxes;
    options.points = input(Eigen::all, thin);
    const LocalLipschitz local = local_lipschitz(observer, false, options);
    box = {local.bound, local_lipschitz(observer, true, options).bound};
    steepest = local.found;
  }

  const Proposition2 proposition{plant_.nx(), system.nz(), slowest(base), base_.l_t, base_.l_tx};
  const auto bounds = [&](const Eigen::VectorXd& v, const Eigen::VectorXd& held, double w) {
    const double z = steady_latent_error(system, v + held, w, map.row_slopes);
    const auto of = [&](const LipschitzConstants& l) -> ErrorBound {
      return {l.latent, lambda, l.latent * z + l.output * v.norm() + approximation};
    };
    BoundSet set{of(lower), of(box), of(upper),
                 bound_19(proposition, k, w, injected_bound(system.injection, v + held))};
    set[kPaperBound].steady += approximation;
    return set;
  };
  result.bounds = bounds(noise, hold, test_.disturbance);
  const BoundSet quiet = bounds(Eigen::VectorXd::Zero(plant_.ny()), quiet_hold, 0.0);

  const double e0 = initial_error(observer, map);
  const Evidence exactly = exact() ? Evidence::kProven : Evidence::kSampled;
  result.constants = {
      {"k lambda", "slowest mode of D_k [1/s]", Evidence::kProven, lambda},
      {"L_T", "|x1 - x2| <= L_T |T(x1) - T(x2)| at k = 1", exactly, base_.l_t},
      {"L_Tx", "sup |dT/dx| at k = 1", exactly, base_.l_tx},
      {"L_Tk", "as L_T, of this k's own T_k", exactly, map.l_t},
      {"L_Tkx", "as L_Tx, of this k's own T_k", exactly, map.l_tx},
      {"l upper", "Lipschitz constant of T*, from its weights", Evidence::kProven, upper.latent},
      {"l box", "the same over the domain's box", Evidence::kProven, box.latent},
      {"l found", "steepest slope of T* found there", Evidence::kSampled, steepest},
      {"l sampled", "largest slope of T* at samples of T(x)", Evidence::kSampled, lower.latent},
      {"w_bar", "largest disturbance |w| of dx/dt", Evidence::kAssumed, test_.disturbance},
      {"v_bar", "sup |F v| at the noise's limit", Evidence::kAssumed, noise_bound},
      {"v_hold", "sup |F (held y - y)| between samples", exactly, hold_bound},
      {"eps", "approximation error of T*, sup |T*(T(x)) - x|", exactly, approximation},
      {"e0", "initial error of z, sup |z(0) - T(x(0))|", starts_are_in_a_box() ? Evidence::kProven : Evidence::kSampled,
       e0},
  };
  if (exact())  // one constant of T*, and no samples
    std::erase_if(result.constants, [](const BoundConstant& c) {
      return c.symbol == "l box" || c.symbol == "l found" || c.symbol == "l sampled";
    });
  if (!exact() || upper.output > 0.0) {  // of every T*, though it may read no y: the table has a column for each k
    result.constants.push_back({"l_y upper", "as l upper, for the y that T* reads", Evidence::kProven, upper.output});
    result.constants.push_back({"l_y box", "the same over the domain's box", Evidence::kProven, box.output});
    result.constants.push_back({"l_y sampled", "largest slope in y at samples", Evidence::kSampled, lower.output});
  }
  constexpr double kRounding = 1e-9;
  result.power_claim_holds = map.l_t <= std::pow(k, static_cast<double>(system.nz())) * base_.l_t * (1.0 + kRounding);
  result.slope_claim_holds = map.l_tx <= base_.l_tx / k * (1.0 + kRounding);
  result.l_tkx = map.l_tx;

  result.measured = measure(observer, map, result.bounds, quiet, approximation);
  for (std::size_t i = 0; i < kBoundKinds; ++i)
    result.transient_s[i] = quiet[i].transient_s(e0, result.measured.transient_level);
  return result;
}

}  // namespace nlo::trainer
