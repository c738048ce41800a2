// SPDX-License-Identifier: MIT
#include "codegen/replay/reference_monitor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codegen/fold/fold.h"

namespace nlo::codegen {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd features(const Model& model, const MatrixXd& steady, const MatrixXd& z, const MatrixXd& y,
                  const MatrixXd& x_hat) {
  MatrixXd all = MatrixXd::Zero(z.rows() + y.rows() + x_hat.rows(), z.cols());
  all.topRows(z.rows()) = z - steady * y;
  for (int j = 0; j < model.nr(); ++j)
    if (!is_relative(model, j)) all.row(z.rows() + j) = y.row(j);
  for (int i = 0; i < model.nx(); ++i)
    if (model.states[static_cast<std::size_t>(i)].wrap == 0.0) all.row(z.rows() + y.rows() + i) = x_hat.row(i);
  return all;
}

double limited(double value, double largest) {
  return std::isnan(value) ? largest : std::clamp(value, -largest, largest);
}

}  // namespace

MatrixXd monitor_features(const Model& model, const Run& run) {
  return features(model, LatentDomain(model).relative_gain(), run.z, run.y, run.x_hat);
}

ReferenceMonitor::ReferenceMonitor(const Model& model, Monitor monitor)
    : model_(model),
      monitor_(std::move(monitor)),
      meanings_(meanings(model, monitor_)),
      steady_(LatentDomain(model).relative_gain()),
      ranges_(flown_ranges(model)),
      gain_((-(-model.sample_period_s / monitor_.windows_s.array()).expm1()).matrix()),
      not_due_(not_due(model)),
      armed_after_(codegen::armed_after(monitor_, model.sample_period_s)) {
  reset();
}

void ReferenceMonitor::reset() {
  const Index ny = model_.ny(), windows = monitor_.windows();
  mean_ = power_ = correlation_ = MatrixXd::Zero(ny, windows);
  variance_ = MatrixXd::Ones(ny, windows);
  distance_ = VectorXd::Ones(windows);
  missing_share_ = y_ = predicted_ = last_ = VectorXd::Zero(ny);
  disagreement_ = VectorXd::Zero(model_.nx());
  place_ = 0.0;
  gated_ = started_ = false;
  missing_ = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(ny, false);
  repeats_.assign(static_cast<std::size_t>(ny), {});
  rejected_ = Eigen::VectorXi::Zero(ny);
  levels_ = VectorXd::Zero(static_cast<Index>(meanings_.size()));
  samples_ = 0;
  all_rejected_ = 0;
}

double ReferenceMonitor::innovation(Index j, double y) const {
  const double wrap = ranges_.wrap(j);
  const double change = wrap > 0.0 ? std::remainder(y - y_(j), wrap) : y - y_(j);
  return (change / monitor_.deviation(j) - predicted_(j)) / (1.0 + monitor_.motion(j) * place_);
}

double ReferenceMonitor::predicted_output(Index j) const {
  return y_(j) + predicted_(j) * monitor_.deviation(j);
}

VectorXd ReferenceMonitor::usable_outputs(const VectorXd& y, double dt_s) {
  VectorXd kept = y;
  const Index measured = model_.measured();
  const int most_rejected = std::min(armed_after_, kMostRejected);
  const bool gap = dt_s > 1.5 * model_.sample_period_s;
  gated_ = true;
  for (Index j = 0; j < measured; ++j) {
    const bool given = std::isfinite(y(j));
    missing_(j) = !given && not_due_[static_cast<std::size_t>(j)] == 0;
    const bool replaces = monitor_.replaces_any() && monitor_.replaces(j) != 0.0;
    if (!given) {
      if (!replaces || !armed() || gap || rejected_(j) >= most_rejected) continue;
      ++rejected_(j);
      kept(j) = predicted_output(j);
      continue;
    }
    Repeats& repeats = repeats_[static_cast<std::size_t>(j)];
    repeats.add(monitor_, j, y(j), kept(static_cast<Index>(monitor_.reference_sensor(j))),
                armed() ? predicted_(j) : 0.0);
    if (!started_) continue;
    bool rejects = false;
    if (armed() && !gap) {
      const double noise = std::max(variance_(j, 0), 1.0);
      const bool beyond = std::abs(innovation(j, y(j))) > monitor_.gate * std::sqrt(noise);
      rejects = beyond && rejected_(j) < most_rejected;
      rejected_(j) = beyond ? std::min(rejected_(j) + 1, most_rejected) : 0;
    }
    missing_(j) = rejects || repeats.frozen();
    if (!missing_(j)) continue;
    kept(j) = rejects && replaces ? predicted_output(j) : std::numeric_limits<double>::quiet_NaN();
    ++all_rejected_;
  }
  for (Index j = measured; j < y.size(); ++j)  // outputs that are computed from measured ones
    missing_(j) = not_due_[static_cast<std::size_t>(j)] == 0 && !kept.head(measured).allFinite();
  return kept;
}

void ReferenceMonitor::watch(const VectorXd& z, const VectorXd& readings, const VectorXd& x_hat,
                             const std::vector<StepStatus>& status, const std::vector<bool>& arrived) {
  const double largest = kLargestInnovation;
  const Index ny = model_.ny(), windows = monitor_.windows();
  started_ = true;
  bool stale = false;
  for (Index j = 0; j < ny; ++j) {
    const StepStatus own = status[static_cast<std::size_t>(j)];
    Repeats& repeats = repeats_[static_cast<std::size_t>(j)];
    const bool slow = not_due_[static_cast<std::size_t>(j)] > 0;
    const bool is_new = !slow || arrived.empty() || arrived[static_cast<std::size_t>(j)];
    if (!gated_) {
      missing_(j) = false;
      if (own < StepStatus::kHeld && is_new)
        repeats.add(monitor_, j, readings(j), readings(static_cast<Index>(monitor_.reference_sensor(j))),
                    armed() ? predicted_(j) : 0.0);
    }
    missing_(j) = missing_(j) || own >= StepStatus::kHeld || repeats.frozen();
    stale = stale || own >= StepStatus::kStale;
    missing_share_(j) += gain_(0) * ((missing_(j) ? 1.0 : 0.0) - missing_share_(j));
    if (missing_(j) || samples_ == 0) continue;
    const double e = is_new ? limited(innovation(j, readings(j)), largest) : last_(j);
    for (Index w = 0; w < windows; ++w) {
      mean_(j, w) += gain_(w) * (e - mean_(j, w));
      power_(j, w) += gain_(windows - 1) * (mean_(j, w) * mean_(j, w) - power_(j, w));
      variance_(j, w) += gain_(w) * (e * e - variance_(j, w));
      if (!slow) correlation_(j, w) += gain_(w) * (e * last_(j) - correlation_(j, w));
    }
    last_(j) = e;
  }
  gated_ = false;
  const VectorXd read = features(model_, steady_, z, readings, x_hat);
  const VectorXd off = (read.head(z.size()) - monitor_.latent_mean).cwiseQuotient(monitor_.latent_deviation);
  place_ = limited(off.cwiseAbs().mean(), largest);
  const double distance = limited(off.squaredNorm() / static_cast<double>(off.size()), largest * largest);
  distance_.array() += gain_.array() * (distance - distance_.array());
  predicted_ = (monitor_.prediction * read + monitor_.offset).cwiseQuotient(monitor_.deviation);
  y_ = readings.head(ny);
  samples_ = stale ? 0 : std::min(samples_ + 1, armed_after_ + 1);
  for (Index i = 0; i < model_.nx(); ++i) {
    if (monitor_.row_deviation(i) == 0.0) continue;
    const double fit = monitor_.row.row(i).dot(read.head(z.size() + model_.nr())) + monitor_.row_offset(i);
    const double size = limited(std::abs(x_hat(i) - fit) / monitor_.row_deviation(i), largest * largest);
    disagreement_(i) += gain_(windows > 1 ? 1 : 0) * (size - disagreement_(i));
  }

  Index at = 0;
  for (Index j = 0; j < ny; ++j)
    for (Index w = 0; w < windows; ++w) {
      const double noise = std::max(variance_(j, w), monitor_.least_variance(j));
      levels_(at++) = power_(j, w) / noise / monitor_.mean_limit(j, w);
      levels_(at++) = variance_(j, w) / monitor_.variance_limit(j, w);
      levels_(at++) = std::abs(correlation_(j, w)) / monitor_.correlation_limit(j, w);
    }
  levels_.segment(at, windows) = distance_.cwiseQuotient(monitor_.latent_limit);
  levels_.segment(at + windows, ny) = missing_share_.cwiseQuotient(monitor_.missing_limit);
  for (Index i = 0; i < model_.nx(); ++i)
    levels_(at + windows + ny + i) =
        monitor_.row_deviation(i) == 0.0 ? 0.0 : disagreement_(i) / monitor_.disagreement_limit(i);
}

VectorXd ReferenceMonitor::widened(const VectorXd& sigma) const {
  constexpr auto unknown = static_cast<double>(kUnknownSigma);
  if (alarm() != Alarm::kNone) return VectorXd::Constant(sigma.size(), unknown);
  const VectorXd wider = (disagreement_ / kOrdinaryDisagreement).cwiseMax(1.0);
  return (sigma.array() < unknown).select(sigma.cwiseProduct(wider), sigma);
}

Alarm ReferenceMonitor::alarm() const {
  Index worst = 0;
  const Index missing = static_cast<Index>(meanings_.size()) - model_.nx() - model_.ny();
  if (!armed()) return levels_.segment(missing, model_.ny()).maxCoeff() > 1.0 ? Alarm::kMissing : Alarm::kNone;
  if (!(levels_.maxCoeff(&worst) > 1.0)) return Alarm::kNone;
  return meanings_[static_cast<std::size_t>(worst)];
}

std::vector<Alarm> ReferenceMonitor::meanings(const Model& model, const Monitor& monitor) {
  std::vector<Alarm> all;
  for (Index each = 0; each < model.ny() * monitor.windows(); ++each)
    all.insert(all.end(), {Alarm::kInnovationMean, Alarm::kInnovationVariance, Alarm::kInnovationCorrelation});
  all.insert(all.end(), static_cast<std::size_t>(monitor.windows()), Alarm::kLatentDistance);
  all.insert(all.end(), static_cast<std::size_t>(model.ny()), Alarm::kMissing);
  all.insert(all.end(), static_cast<std::size_t>(model.nx()), Alarm::kDisagreement);
  return all;
}

WatchedRun watched_run(const Model& model, const Monitor& monitor, const MatrixXd& outputs, const MatrixXd& inputs,
                       const VectorXd& time_s, Gate gate) {
  ReferenceObserver<float> observer(model);
  ReferenceMonitor watch(model, monitor);
  const Index samples = outputs.cols();
  WatchedRun all{
      {MatrixXd::Zero(model.nx(), samples), MatrixXd::Zero(model.nz(), samples), MatrixXd::Zero(model.nr(), samples)},
      MatrixXd::Zero(watch.levels().size(), samples),
      std::vector<Alarm>(static_cast<std::size_t>(samples), Alarm::kNone)};
  if (model.error)
    all.run.sigma = all.run.widened_sigma = MatrixXd::Constant(model.nx(), samples, static_cast<double>(kUnknownSigma));
  std::vector<StepStatus> status(static_cast<std::size_t>(model.ny()));
  std::vector<bool> arrived(status.size(), true);
  bool started = false;
  for (Index k = 0; k < samples; ++k) {
    const VectorXd u = inputs.size() == 0 ? VectorXd() : VectorXd(inputs.col(k));
    const double dt_s = time_s.size() == 0 || k == 0 ? 0.0 : time_s(k) - time_s(k - 1);
    const VectorXd y = gate == Gate::kUsed ? watch.usable_outputs(outputs.col(k), dt_s) : VectorXd(outputs.col(k));
    if (dt_s == 0.0)
      observer.step(y, u);
    else
      observer.step(y, u, dt_s);
    started = started || outputs.col(k).allFinite();
    all.run.status.push_back(observer.status());
    all.run.in_domain.push_back(observer.in_domain());
    if (!started) continue;
    all.run.z.col(k) = observer.latent().cast<double>();
    all.run.y.col(k) = observer.output();
    all.run.x_hat.col(k) = observer.estimate().cast<double>();
    for (Index j = 0; j < model.ny(); ++j) {
      status[static_cast<std::size_t>(j)] = observer.status(j);
      arrived[static_cast<std::size_t>(j)] = observer.has_arrived(j);
    }
    watch.watch(all.run.z.col(k), all.run.y.col(k), all.run.x_hat.col(k), status, arrived);
    all.levels.col(k) = watch.levels();
    all.alarms[static_cast<std::size_t>(k)] = watch.alarm();
    if (!model.error) continue;
    all.run.sigma.col(k) = observer.deviations(all.run.z.col(k), all.run.y.col(k), {observer.error_is_known()});
    all.run.widened_sigma.col(k) = watch.widened(all.run.sigma.col(k));
  }
  all.armed_after = armed_after(monitor, model.sample_period_s);
  all.rejected = watch.rejected();
  return all;
}

}  // namespace nlo::codegen
