// SPDX-License-Identifier: MIT
#include "codegen/replay/reference_observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/fail.h"
#include "codegen/model_file/validate.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

/// Relative. Time stamps of 10^5 s in double give steps with errors of 1e-8 at 1 kHz, which do not change z in float.
constexpr double kSameStep = 1e-8;

const Model& validated(const Model& model) {
  validate(model);
  return model;
}

/// Returns true if z is within the limits of the runtime.
template <class Vector>
bool is_latent(const Vector& z) {
  return z.allFinite() && z.cwiseAbs().maxCoeff() <= typename Vector::Scalar(0x1p100);
}

template <class Scalar>
std::unique_ptr<ReferenceDynamics<Scalar>> dynamics_of(const Model& m, Activations activations,
                                                       const QuantisedModel* integers) {
  if constexpr (std::is_same_v<Scalar, float>)
    if (integers != nullptr && integers->units) return module_of(m).dynamics_in_integers(m, *integers->units);
  if constexpr (std::is_same_v<Scalar, float>) return module_of(m).dynamics_in_float(m, activations);
  if constexpr (std::is_same_v<Scalar, double>) return module_of(m).dynamics_in_double(m, activations);
}

}  // namespace

template <class Scalar>
ReferenceObserver<Scalar>::ReferenceObserver(const Model& model)
    : ReferenceObserver(validated(model), Activations::kExact, flown_ranges(model)) {}

template <class Scalar>
ReferenceObserver<Scalar>::ReferenceObserver(const Model& model, Activations activations, FlownRanges ranges,
                                             const QuantisedModel* integers)
    : model_(std::make_unique<const Model>(model)),
      domain_(*model_),
      steady_gain_(steady_gain(*model_)),
      validation_(std::make_unique<SampleValidation>(*model_, std::move(ranges))),
      dynamics_(dynamics_of<Scalar>(*model_, activations, integers)) {
  if (const Network* map = codegen::inverse_map(model)) inverse_map_.emplace(*map, activations);
  if (model.saturates()) saturated_.emplace(model);
  reset();
}

template <class Scalar>
void ReferenceObserver<Scalar>::reset() {
  z_ = model_->initial_latent.cast<Scalar>();
  validation_->reset();
  status_ = StepStatus::kOk;
  started_ = false;
}

template <class Scalar>
void ReferenceObserver<Scalar>::step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) {
  take(y, u, true, model_->sample_period_s);
}

template <class Scalar>
void ReferenceObserver<Scalar>::step(const Eigen::VectorXd& y, const Eigen::VectorXd& u, double dt_s) {
  take(y, u, true, dt_s);
}

// [started, status, z, state of the validation]
template <class Scalar>
Eigen::Index ReferenceObserver<Scalar>::snapshot_size() const {
  return 2 + z_.size() + validation_->held_values().size();
}

template <class Scalar>
Eigen::VectorXd ReferenceObserver<Scalar>::snapshot() const {
  Eigen::VectorXd all(snapshot_size());
  all << (started_ ? 1.0 : 0.0), static_cast<double>(status_), z_.template cast<double>(), validation_->held_values();
  return all;
}

template <class Scalar>
void ReferenceObserver<Scalar>::restore(const Eigen::VectorXd& snapshot) {
  if (snapshot.size() != snapshot_size())
    fail("a saved state of \"{}\" has {} numbers, this one has {}: it belongs to another model", model_->name,
         snapshot_size(), snapshot.size());
  const auto whole = [&](Eigen::Index at, double most) {
    const double value = snapshot(at);
    if (!(value >= 0.0 && value <= most && value == std::floor(value)))
      fail("number {} of the saved state is {}, but it must be an integer from 0 to {}: the state was changed", at,
           value, most);
    return value;
  };
  const bool started = whole(0, 1.0) == 1.0;
  const auto status = static_cast<StepStatus>(whole(1, static_cast<double>(StepStatus::kReset)));
  const Vector z = snapshot.segment(2, z_.size()).template cast<Scalar>();
  if (!is_latent(z)) fail("z of the saved state is not finite: it was changed");
  const Eigen::Index counted = snapshot.size() - validation_->channels();
  for (Eigen::Index k = counted; k < snapshot.size(); ++k) whole(k, std::numeric_limits<int>::max());
  if (!snapshot.head(counted).allFinite()) fail("a reading of the saved state is not finite: it was changed");
  validation_->hold(snapshot.tail(snapshot.size() - 2 - z_.size()), started);
  z_ = z;
  last_y_ = validation_->y().template cast<Scalar>();
  last_u_ = validation_->u().template cast<Scalar>();
  status_ = status;
  started_ = started;
}

template <class Scalar>
auto ReferenceObserver<Scalar>::estimate() const -> Vector {
  return estimate_of(z_, validation_->y().template cast<Scalar>());
}

template <class Scalar>
Run ReferenceObserver<Scalar>::run(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                   const Eigen::VectorXd& time_s, bool uniform, Angles angles) {
  const Eigen::Index samples = outputs.cols();
  const int nu = model_->nu();
  if (nu != inputs.rows() || (nu > 0 && inputs.cols() != samples))
    throw Error(fmt::format(
        "\"{}\" has {} inputs over {} samples, but the data has {} x {}: give the inputs the names that the model uses",
        model_->name, nu, samples, inputs.rows(), inputs.cols()));
  Run run{Eigen::MatrixXd(model_->nx(), samples), Eigen::MatrixXd(model_->nz(), samples),
          Eigen::MatrixXd(model_->nr(), samples)};
  Matrix z(model_->nz(), samples), y(model_->nr(), samples);
  reset();
  const double period_s = model_->sample_period_s;
  std::vector<bool> known;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double since_last_s = uniform || k == 0 ? period_s : time_s(k) - time_s(k - 1);
    const bool nominal = std::abs(since_last_s - period_s) <= kSameStep * period_s;
    take(outputs.col(k), nu > 0 ? Eigen::VectorXd(inputs.col(k)) : Eigen::VectorXd(), angles == Angles::kWrapped,
         nominal ? period_s : since_last_s);
    run.status.push_back(status_);
    run.in_domain.push_back(in_domain());
    known.push_back(error_is_known());
    z.col(k) = z_;
    y.col(k) = output().template cast<Scalar>();
    run.y.col(k) = output();
  }
  run.x_hat = estimates_in_blocks(z, y);
  run.z = z.template cast<double>();
  run.sigma = deviations(run.z, run.y, known);
  return run;
}

template <class Scalar>
Eigen::MatrixXd ReferenceObserver<Scalar>::estimates(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const {
  return estimates_in_blocks(z.cast<Scalar>(), y.cast<Scalar>());
}

template <class Scalar>
void ReferenceObserver<Scalar>::take(const Eigen::VectorXd& y, const Eigen::VectorXd& u, bool wrapped, double dt_s) {
  status_ = StepStatus::kRejected;
  if (started_ && !(dt_s > 0.0 && dt_s <= dynamics_->longest_step_s())) return;
  const bool usable = validation_->validate(y, u, wrapped, dt_s);
  status_ = validation_->status();
  if (!usable) return;
  next_y_ = validation_->y().template cast<Scalar>();
  next_u_ = validation_->u().template cast<Scalar>();
  if (started_) {
    advance(dt_s);
  } else {
    Matrix z = z_;
    dynamics_->start(z, next_y_, &validation_->arrived());
    z_ = z;
  }
  if (started_) turn_back();
  last_y_ = validation_->y().template cast<Scalar>();
  last_u_ = next_u_;
  started_ = true;
}

/// Turns back outputs that T* reads only relatively, as in flight. Angles stay unwrapped.
template <class Scalar>
void ReferenceObserver<Scalar>::turn_back() {
  const Eigen::VectorXd back = validation_->turn_back();
  if (back.isZero(0.0)) return;
  z_ -= (steady_gain_ * back).template cast<Scalar>();
}

template <class Scalar>
void ReferenceObserver<Scalar>::advance(double dt_s) {
  candidate_ = z_;
  // An input that is given now has acted since the last sample.
  const auto read = static_cast<Eigen::Index>(model_->inputs.size());
  if (model_->input_hold == Hold::kZeroOrder) last_y_.segment(model_->ny(), read) = next_y_.segment(model_->ny(), read);
  dynamics_->advance(candidate_, {last_y_, next_y_, last_u_, next_u_, &validation_->arrived()}, dt_s);
  if (is_latent(candidate_)) {
    z_ = candidate_;
  } else {
    status_ = StepStatus::kDiverged;
  }
}

/// Computes the inverse map by matrix products over blocks of samples.
template <class Scalar>
Eigen::MatrixXd ReferenceObserver<Scalar>::estimates_in_blocks(const Matrix& z, const Matrix& y) const {
  constexpr Eigen::Index kBlock = 512;  // 50 neurons x 512 floats: a layer's input and output stay in the L2 cache
  Eigen::MatrixXd x_hat(model_->nx(), z.cols());
  for (Eigen::Index k = 0; k < z.cols(); k += kBlock) {
    const Eigen::Index n = std::min(kBlock, z.cols() - k);
    x_hat.middleCols(k, n) = estimate_of(z.middleCols(k, n), y.middleCols(k, n)).template cast<double>();
  }
  return x_hat;
}

/// Returns x_hat for each column of z (n_z x B) and readings y (n_r x B).
template <class Scalar>
auto ReferenceObserver<Scalar>::estimate_of(const Matrix& z, const Matrix& y) const -> Matrix {
  if (!inverse_map_) return z;
  Matrix x_hat = (*inverse_map_)(read_by_map(z, y));
  dynamics_->finish(x_hat);
  return x_hat;
}

/// Returns the z that T* reads.
template <class Scalar>
auto ReferenceObserver<Scalar>::saturated(const Matrix& z, const Matrix& y) const -> Matrix {
  if (!saturated_) return z;
  Matrix within(z.rows(), z.cols());
  for (Eigen::Index b = 0; b < z.cols(); ++b)
    within.col(b) = saturated_->saturated(z.col(b).template cast<double>(), y.col(b).template cast<double>())
                        .template cast<Scalar>();
  return within;
}

/// Returns z, or [z; y].
template <class Scalar>
auto ReferenceObserver<Scalar>::read_by_map(const Matrix& z, const Matrix& y) const -> Matrix {
  const Matrix within = saturated(z, y);
  return codegen::inverse_map(*model_)->inputs() == z.rows() ? within : stacked<Scalar>(within, y);
}

template <class Scalar>
Eigen::MatrixXd ReferenceObserver<Scalar>::last_hidden(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) const {
  return inverse_map_->last_hidden(read_by_map(z.cast<Scalar>(), y.cast<Scalar>())).template cast<double>();
}

template <class Scalar>
bool ReferenceObserver<Scalar>::in_domain() const {
  return !validation_->clamped() && domain_.contains(z_.template cast<double>(), output());
}

template <class Scalar>
Eigen::MatrixXd ReferenceObserver<Scalar>::deviations(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y,
                                                      const std::vector<bool>& known) const {
  if (!model_->error) return {};
  return codegen::deviations(*model_->error, last_hidden(z, y), known);
}

template class ReferenceObserver<float>;
template class ReferenceObserver<double>;

}  // namespace nlo::codegen
