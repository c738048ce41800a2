// SPDX-License-Identifier: MIT
#include "codegen/replay/sample_validation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "codegen/fold/fold.h"

namespace nlo::codegen {

SampleValidation::SampleValidation(const Model& model, FlownRanges ranges)
    : model_(model),
      computed_(model.outputs, model.inputs),
      stale_after_(stale_after(model)),
      not_due_(not_due(model)),
      ranges_(std::move(ranges)) {
  reset();
}

void SampleValidation::reset() {
  y_ = Eigen::VectorXd::Zero(model_.nr());
  u_ = Eigen::VectorXd::Zero(model_.inputs.empty() ? model_.nu() : 0);
  status_ = StepStatus::kOk;
  not_due_.resize(static_cast<std::size_t>(y_.size() + u_.size()), 0);  // an input is due in every sample
  health_.assign(not_due_.size(), Health{});
  arrived_.assign(model_.outputs.size(), false);
  for (std::size_t i = 0; i < health_.size(); ++i)  // a slow output has not arrived yet
    if (not_due_[i] > 0) health_[i] = {most_missing(not_due_[i]) + 1, true};
  started_ = false;
}

Eigen::VectorXd SampleValidation::turn_back() {
  Eigen::VectorXd back = Eigen::VectorXd::Zero(y_.size());
  for (int j = 0; j < model_.ny(); ++j) {
    if (!(ranges_.wrap(j) > 0.0) || model_.outputs[static_cast<std::size_t>(j)].wrap > 0.0) continue;
    back(j) = ranges_.wrap(j) * whole_turns(y_(j), ranges_.wrap(j));
  }
  y_ -= back;
  return back;
}

// Each channel has one number for its health: 8 times its count plus one bit each for held, clamped and late.
Eigen::VectorXd SampleValidation::held_values() const {
  Eigen::VectorXd all(y_.size() + u_.size() + channels());
  all.head(y_.size()) = y_;
  all.segment(y_.size(), u_.size()) = u_;
  Eigen::Index next = y_.size() + u_.size();
  for (const Health& h : health_)
    all(next++) = 8.0 * h.count + (h.held ? 1.0 : 0.0) + (h.clamped ? 2.0 : 0.0) + (h.late ? 4.0 : 0.0);
  return all;
}

void SampleValidation::hold(const Eigen::VectorXd& values, bool started) {
  y_ = values.head(y_.size());
  u_ = values.segment(y_.size(), u_.size());
  Eigen::Index next = y_.size() + u_.size();
  for (Health& h : health_) {
    const int code = static_cast<int>(values(next++));
    h = {code / 8, (code & 1) != 0, (code & 2) != 0, (code & 4) != 0};
  }
  started_ = started;
}

int SampleValidation::late(std::size_t channel) const {
  const int count = health_[channel].count;
  return count > most_missing(not_due_[channel]) ? count - not_due_[channel] : 0;
}

StepStatus SampleValidation::status_of(std::size_t channel) const {
  const Health& h = health_[channel];
  if (not_due_[channel] > 0 && may_fail(channel)) {
    if (h.clamped) return StepStatus::kClamped;
    return late(channel) > 0 ? StepStatus::kHeld : StepStatus::kOk;
  }
  const int count = h.clamped ? h.count : late(channel);
  if (count == 0) return StepStatus::kOk;
  if (count >= stale_after_) return h.clamped ? StepStatus::kOutOfRange : StepStatus::kStale;
  const bool missed_in_gap = h.late && not_due_[channel] == 0;
  return h.clamped && !missed_in_gap ? StepStatus::kClamped : StepStatus::kHeld;
}

bool SampleValidation::clamped() const {
  return std::any_of(health_.begin(), health_.end(), [](const Health& h) { return h.clamped; });
}

int SampleValidation::missed_samples(double dt_s) const {
  const double periods = dt_s / model_.sample_period_s;
  return started_ && periods > 1.5 ? static_cast<int>(std::round(periods)) - 1 : 0;
}

bool SampleValidation::may_fail(std::size_t channel) const {
  const std::vector<int>& outputs = model_.failures.outputs;
  return std::find(outputs.begin(), outputs.end(), static_cast<int>(channel)) != outputs.end();
}

SampleValidation::Filled SampleValidation::fill_missing(Eigen::VectorXd& readings, double dt_s) const {
  const SensorFailures& failures = model_.failures;
  const auto size = static_cast<std::size_t>(readings.size());
  Filled filled{std::vector<bool>(size, false), std::vector<int>(size, 0)};
  const double keep = started_ ? std::exp(-dt_s / failures.staleness_s) : 0.0;
  for (std::size_t i = 0; i < failures.outputs.size(); ++i) {
    const Eigen::Index output = failures.outputs[i];
    const auto index = static_cast<Eigen::Index>(i);
    const Eigen::Index flag = readings.size() - static_cast<Eigen::Index>(failures.outputs.size()) + index;
    const auto channel = static_cast<std::size_t>(output);
    const bool given = std::isfinite(readings(output));
    if (not_due_[channel] > 0) {
      const Health& h = health_[channel];
      int& age = filled.age[channel];
      if (!given) age = (h.held || h.clamped ? h.count : 0) + missed_samples(dt_s) + 1;
      if (!given && age <= most_missing(not_due_[channel])) readings(output) = y_(output);
    }
    const bool missing = !std::isfinite(readings(output));
    filled.missing[channel] = missing;
    if (missing) readings(output) = failures.rest(index) + keep * (y_(output) - failures.rest(index));
    readings(flag) = missing ? 1.0 - keep * (1.0 - y_(flag)) : keep * y_(flag);
  }
  return filled;
}

bool SampleValidation::validate(const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, bool wrapped,
                                double dt_s) {
  Eigen::MatrixXd given = outputs;
  Eigen::VectorXd u = inputs;
  computed_.fill(given, inputs);
  Eigen::VectorXd y = given.col(0);
  if (y_.size() > outputs.size()) {  // inputs that are readings, and stalenesses
    y.conservativeResize(y_.size());
    if (!model_.inputs.empty()) {
      y.segment(outputs.size(), inputs.size()) = inputs;
      u.resize(0);
    }
  }
  const Filled filled = fill_missing(y, dt_s);
  const int missed = missed_samples(dt_s);
  const auto update = [&](Eigen::Index channel, bool held, bool clamped) {
    constexpr int kMost = 1 << 20;
    Health& h = health_[static_cast<std::size_t>(channel)];
    const bool good = !held && !clamped;
    const bool is_slow = not_due_[static_cast<std::size_t>(channel)] > 0;
    const bool in_use = is_slow && h.clamped && held;  // the clamped value is still in use
    h.count = (h.held || h.clamped ? h.count : 0) + missed;
    if (clamped && !h.clamped) h.count = late(static_cast<std::size_t>(channel));
    h = {good && missed == 0 ? 0 : std::min(h.count + (good ? 0 : 1), kMost), held, clamped || in_use, missed > 0};
  };
  Eigen::VectorXd good_y = y, good_u = u;
  for (int j = 0; j < y.size(); ++j) {
    const double wrap = ranges_.wrap(j), low = ranges_.min(j), high = ranges_.max(j);
    const bool is_angle = j < model_.ny() && model_.outputs[static_cast<std::size_t>(j)].wrap > 0.0;
    const bool outside = y(j) < low || y(j) > high;
    bool clamped = false;
    if (wrap == 0.0) {
      clamped = std::isfinite(y(j)) && outside;
      if (clamped) good_y(j) = std::clamp(y(j), low, high);
    } else if (wrapped || !is_angle) {
      if (outside) good_y(j) = std::nan("");
      good_y(j) -= wrap * whole_turns(good_y(j) - y_(j), wrap);
    }
    const bool held = !std::isfinite(good_y(j));
    const auto channel = static_cast<std::size_t>(j);
    const bool was_clamped = health_[channel].clamped;
    update(j, held, clamped);
    if (not_due_[channel] > 0 && may_fail(channel)) {
      Health& h = health_[channel];
      if (const int age = filled.age[channel]; age > 0) {
        const bool late = age > most_missing(not_due_[channel]);
        h = {std::min(age, 1 << 20), true, was_clamped && !late, missed > 0};
      } else if (h.clamped) {
        h.count = 1;
      }
    } else if (filled.missing[channel]) {
      health_[channel] = {1, true};
    }
    const bool known = not_due_[channel] > 0 && (health_[channel].clamped || late(channel) == 0);
    if (held && (started_ || known)) good_y(j) = y_(j);
    // Until every other channel has a value, the values that have arrived are kept.
    if (!started_ && not_due_[channel] > 0 && std::isfinite(good_y(j))) y_(j) = good_y(j);
  }
  for (std::size_t j = 0; j < arrived_.size(); ++j) arrived_[j] = !health_[j].held;
  for (Eigen::Index i = 0; i < good_u.size(); ++i) {
    const bool held = !std::isfinite(good_u(i));
    update(y.size() + i, held, false);
    if (held && started_) good_u(i) = u_(i);
  }

  status_ = StepStatus::kOk;
  for (std::size_t i = 0; i < health_.size(); ++i) status_ = std::max(status_, status_of(i));
  if (!good_y.allFinite() || !good_u.allFinite()) return false;
  y_ = good_y;
  u_ = good_u;
  started_ = true;
  return true;
}

}  // namespace nlo::codegen
