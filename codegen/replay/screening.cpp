// SPDX-License-Identifier: MIT
#include "codegen/replay/screening.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "codegen/fold/fold.h"

namespace nlo::codegen {

Screening::Screening(const Model& model)
    : model_(model),
      computed_(model.outputs, model.inputs),
      stale_after_(stale_after(model)),
      low_(reading_min(model)),
      high_(reading_max(model)) {
  for (const Channel& channel : readings(model)) wrap_.push_back(channel.wrap);
  reset();
}

void Screening::reset() {
  y_ = Eigen::VectorXd::Zero(model_.nr());
  u_ = Eigen::VectorXd::Zero(model_.inputs.empty() ? model_.nu() : 0);
  status_ = StepStatus::kOk;
  held_.assign(static_cast<std::size_t>(y_.size() + u_.size()), 0);
  started_ = false;
}

Eigen::VectorXd Screening::held_values() const {
  Eigen::VectorXd all(y_.size() + u_.size() + counters());
  all << y_, u_, Eigen::Map<const Eigen::VectorXi>(held_.data(), counters()).cast<double>();
  return all;
}

void Screening::hold(const Eigen::VectorXd& values, bool started) {
  y_ = values.head(y_.size());
  u_ = values.segment(y_.size(), u_.size());
  Eigen::Map<Eigen::VectorXi>(held_.data(), counters()) = values.tail(counters()).cast<int>();
  started_ = started;
}

bool Screening::fill_missing(Eigen::VectorXd& readings, double dt_s) const {
  const SensorFailures& failures = model_.failures;
  const double keep = started_ ? std::exp(-dt_s / failures.staleness_s) : 0.0;
  bool any = false;
  for (std::size_t i = 0; i < failures.outputs.size(); ++i) {
    const Eigen::Index output = failures.outputs[i];
    const auto index = static_cast<Eigen::Index>(i);
    const Eigen::Index flag = readings.size() - static_cast<Eigen::Index>(failures.outputs.size()) + index;
    const bool missing = !std::isfinite(readings(output));
    if (missing) readings(output) = failures.rest(index) + keep * (y_(output) - failures.rest(index));
    readings(flag) = missing ? 1.0 - keep * (1.0 - y_(flag)) : keep * y_(flag);
    any = any || missing;
  }
  return any;
}

StepStatus Screening::status(Eigen::Index output) const {
  const int held = held_[static_cast<std::size_t>(output)];
  if (held >= stale_after_) return StepStatus::kStale;
  return held > 0 || (missing_.size() > 0 && missing_(output)) ? StepStatus::kHeld : StepStatus::kOk;
}

bool Screening::take(const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, bool wrapped, double dt_s) {
  Eigen::MatrixXd given = outputs;
  Eigen::VectorXd u = inputs;
  computed_.fill(given, inputs);
  Eigen::VectorXd y = given.col(0);
  if (y_.size() > outputs.size()) {  // inputs are readings, and stalenesses
    y.conservativeResize(y_.size());
    if (!model_.inputs.empty()) {
      y.segment(outputs.size(), inputs.size()) = inputs;
      u.resize(0);
    }
  }
  missing_ = !given.col(0).array().isFinite();
  const bool missing = fill_missing(y, dt_s);
  Eigen::VectorXd good_y = y, good_u = u;
  bool clamped = false;
  const auto hold = [&](Eigen::Index channel, bool held) {
    int& times = held_[static_cast<std::size_t>(channel)];
    times = held ? std::min(times, std::numeric_limits<int>::max() - 1) + 1 : 0;
  };
  for (int j = 0; j < y.size(); ++j) {
    const double wrap = wrap_[static_cast<std::size_t>(j)];
    const double low = low_(j), high = high_(j);
    const bool outside = y(j) < low || y(j) > high;
    if (wrap == 0.0) {
      if (std::isfinite(y(j))) good_y(j) = std::clamp(y(j), low, high);
      clamped = clamped || outside;
    } else if (wrapped) {
      if (outside) good_y(j) = std::nan("");
      good_y(j) -= wrap * std::round((good_y(j) - y_(j)) / wrap);
    }
    const bool held = !std::isfinite(good_y(j));
    hold(j, held);
    if (held && started_) good_y(j) = y_(j);
  }
  for (Eigen::Index i = 0; i < good_u.size(); ++i) {
    const bool held = !std::isfinite(good_u(i));
    hold(y.size() + i, held);
    if (held && started_) good_u(i) = u_(i);
  }

  const int longest = *std::max_element(held_.begin(), held_.end());
  status_ = longest >= stale_after_ ? StepStatus::kStale
            : longest > 0           ? StepStatus::kHeld
            : clamped               ? StepStatus::kClamped
                                    : StepStatus::kOk;
  if (missing) status_ = std::max(status_, StepStatus::kHeld);
  if (!good_y.allFinite() || !good_u.allFinite()) return false;
  y_ = good_y;
  u_ = good_u;
  started_ = true;
  return true;
}

}  // namespace nlo::codegen
