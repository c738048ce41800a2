// SPDX-License-Identifier: MIT
#include "trainer/identify/identify.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/NonLinearOptimization>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The interface that Eigen's method needs.
struct Residuals {
  using Scalar = double;
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = MatrixXd;
  // NOLINTNEXTLINE(readability-identifier-naming): Eigen's names
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  ShootingProblem& problem;
  const std::atomic<bool>* stop;

  int inputs() const { return static_cast<int>(problem.space().size()); }
  int values() const { return static_cast<int>(problem.rows()); }
  int operator()(const VectorXd& theta, VectorXd& r) const {
    r = problem.residuals(theta);
    return stop != nullptr && stop->load() ? -1 : 0;
  }
  int df(const VectorXd& theta, MatrixXd& j) const {
    j = problem.jacobian(theta);
    return stop != nullptr && stop->load() ? -1 : 0;
  }
};

struct Solution {
  VectorXd theta;
  int iterations = 0;
  std::string outcome;
  bool stopped = false;
};

double freedom_of(const ShootingProblem& problem) {
  return static_cast<double>(problem.counted() - problem.space().size()) - problem.told_states();
}

double deviation_of(double squares, const ShootingProblem& problem) {
  return std::sqrt(squares / std::max(1.0, freedom_of(problem)));
}

Solution search(ShootingProblem& problem, int most_iterations, const std::atomic<bool>* stop,
                const IdentifyProgress& progress) {
  Residuals residuals{problem, stop};
  Eigen::LevenbergMarquardt<Residuals> method(residuals);
  method.parameters.ftol = method.parameters.xtol = 1e-7;
  method.parameters.maxfev = 100 * most_iterations;
  method.parameters.factor = 1.0;  // theta has unit scale, so the first step has a length of at most 1
  method.useExternalScaling = true;
  method.diag = VectorXd::Ones(problem.space().size());
  Solution solution;
  solution.theta = VectorXd::Zero(problem.space().size());
  auto status = method.minimizeInit(solution.theta);
  VectorXd best = solution.theta;
  while (status == Eigen::LevenbergMarquardtSpace::Running || status == Eigen::LevenbergMarquardtSpace::NotStarted) {
    if (solution.iterations == most_iterations) break;
    status = method.minimizeOneStep(solution.theta);
    if (status == Eigen::LevenbergMarquardtSpace::UserAsked) break;
    best = solution.theta;
    ++solution.iterations;
    if (progress) progress(solution.iterations, deviation_of(method.fnorm * method.fnorm, problem));
  }
  solution.stopped = status == Eigen::LevenbergMarquardtSpace::UserAsked;
  solution.theta = best;
  solution.outcome = solution.stopped ? "stopped"
                     : status == Eigen::LevenbergMarquardtSpace::Running ||
                             status == Eigen::LevenbergMarquardtSpace::TooManyFunctionEvaluation
                         ? fmt::format("not converged in {} iterations", solution.iterations)
                         : "converged";
  return solution;
}

std::vector<FittedError> fitted_errors(const ShootingProblem& problem, const VectorXd& residuals) {
  std::vector<FittedError> errors;
  const auto found = problem.errors(residuals);
  for (std::size_t c = 0; c < found.size(); ++c)
    errors.push_back({problem.channels()[c].name, problem.channels()[c].unit, found[c].rmse, found[c].correlation});
  return errors;
}

/// Covariances of theta, and the coordinates that the data do not determine.
struct Uncertainty {
  MatrixXd white, clustered;
  std::vector<bool> unidentified;
  double condition = 0.0;
};

Uncertainty uncertainty_of(const ShootingProblem& problem, const MatrixXd& j, const VectorXd& r, double deviation) {
  constexpr double kNoEffect = 1e-7;  // singular values below it are within the error of forward differences
  constexpr double kShare = 0.1;
  const Index n = j.cols();
  const VectorXd length = j.colwise().norm().transpose().cwiseMax(std::numeric_limits<double>::min());
  const Eigen::JacobiSVD<MatrixXd, Eigen::HouseholderQRPreconditioner> svd(j * length.cwiseInverse().asDiagonal(),
                                                                           Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& singular = svd.singularValues();
  Uncertainty result;
  result.unidentified.assign(static_cast<std::size_t>(n), false);
  VectorXd inverse = VectorXd::Zero(n);
  for (Index k = 0; k < n; ++k) {
    if (singular[k] > kNoEffect * singular[0]) {
      inverse[k] = 1.0 / singular[k];
      continue;
    }
    for (Index i = 0; i < n; ++i)
      if (std::abs(svd.matrixV()(i, k)) > kShare) result.unidentified[static_cast<std::size_t>(i)] = true;
  }
  result.condition = singular[n - 1] > 0.0 ? singular[0] / singular[n - 1] : std::numeric_limits<double>::infinity();
  const MatrixXd root = length.cwiseInverse().asDiagonal() * svd.matrixV() * inverse.asDiagonal();
  const MatrixXd normal = root * root.transpose();  // (J'J)^-1
  result.white = deviation * deviation * normal;
  result.clustered = normal * problem.scatter(j, r) * normal;
  return result;
}

}  // namespace

IdentificationResult identify(const Identification& identification, const Dataset& training, const Dataset& test,
                              ThreadPool& pool, const std::atomic<bool>* stop, const IdentifyProgress& progress) {
  ShootingProblem problem(identification, training, pool);
  const ParameterSpace& space = problem.space();
  if (problem.counted() <= space.size())
    throw codegen::Error(fmt::format("[identify]: {} residuals for {} parameters; use longer segments or more logs",
                                     problem.counted(), space.size()));
  {
    const VectorXd at_start = problem.residuals(VectorXd::Zero(space.size()));
    constexpr double kHopeless = 1e5;  // [deviations]; larger residuals mean that the simulation has diverged
    if (!(at_start.cwiseAbs().maxCoeff() < kHopeless))
      throw codegen::Error(
          "[plant] parameters: the simulation with the start values diverges; give better start values, use shorter "
          "segments "
          "([identify] segment_s) or a shorter longest_step_s");
  }
  const Solution solution = search(problem, identification.identify.iterations, stop, progress);

  IdentificationResult result;
  const VectorXd r = problem.residuals(solution.theta);
  const MatrixXd j = problem.jacobian(solution.theta);
  result.values = space.parameters(solution.theta);
  result.segments = problem.segments();
  result.samples = problem.samples();
  result.residuals = problem.counted();
  result.degrees_of_freedom = freedom_of(problem);
  result.residual_deviation = deviation_of(problem.squares(r), problem);
  result.iterations = solution.iterations;
  result.outcome = solution.outcome;
  result.stopped = solution.stopped;
  const Uncertainty uncertainty = uncertainty_of(problem, j, r, result.residual_deviation);
  result.condition = uncertainty.condition;

  for (std::size_t i = 0; i < identification.plant.parameters.size(); ++i) {
    const auto& [name, start] = identification.plant.parameters[i];
    result.parameters.push_back({name, start, result.values[static_cast<Index>(i)], 0.0, 0.0, true, false, false});
  }
  const VectorXd slope = space.slope(solution.theta).cwiseAbs();
  for (Index k = 0; k < space.size(); ++k) {
    ParameterEstimate& estimate = result.parameters[static_cast<std::size_t>(space.index(k))];
    estimate.fixed = false;
    estimate.standard_error = slope[k] * std::sqrt(uncertainty.white(k, k));
    estimate.clustered_error = slope[k] * std::sqrt(uncertainty.clustered(k, k));
    estimate.at_bound = space.at_bound(k, estimate.value);
    estimate.unidentified = uncertainty.unidentified[static_cast<std::size_t>(k)];
  }
  result.training = fitted_errors(problem, r);
  if (!test.trajectories.empty()) {
    ShootingProblem on_test(identification, test, pool);
    result.test = fitted_errors(on_test, on_test.residuals(solution.theta));
  }
  return result;
}

}  // namespace nlo::trainer
