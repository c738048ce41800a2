// SPDX-License-Identifier: MIT
#include "trainer/identify/identified_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "trainer/data/angle.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/judge/filters/filter_bank.h"
#include "trainer/plants/parametric_plant.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index logged_row(const std::vector<Channel>& channels, const std::string& name) {
  return std::find_if(channels.begin(), channels.end(), [&](const Channel& c) { return c.name == name; }) -
         channels.begin();
}

VectorXd as_vector(const std::vector<double>& values) {
  return VectorXd::Map(values.data(), static_cast<Index>(values.size()));
}

MatrixXd rows_of(const MatrixXd& all, const std::vector<Index>& rows) {
  MatrixXd result(static_cast<Index>(rows.size()), all.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) result.row(static_cast<Index>(i)) = all.row(rows[i]);
  return result;
}

Index state_row(const PlantConfig& plant, const std::string& name) {
  return std::ranges::find(plant.states, name) - plant.states.begin();
}

double noise_of(const Identification& identification, const std::string& output) {
  for (const auto& [name, deviation] : identification.identify.noise)
    if (name == output) return deviation;
  return 1.0;  // not reached, because every output has a noise
}

}  // namespace

std::vector<HiddenAngle> hidden_angles(const Identification& identification,
                                       const std::vector<Channel>& logged_states) {
  std::vector<HiddenAngle> hidden;
  for (std::size_t i = 0; i < logged_states.size(); ++i) {
    const Channel& state = logged_states[i];
    const Index row = state_row(identification.plant, state.name);
    const std::vector<std::string>& outputs = identification.plant.output_names;
    const bool is_measured = std::ranges::find(outputs, state.name) != outputs.end();
    const double anywhere = state.wrap / std::sqrt(12.0);  // deviation of a uniform distribution over the turn
    if (state.wrap > 0.0 && !is_measured &&
        identification.identify.initial_deviation[static_cast<std::size_t>(row)] >= anywhere)
      hidden.push_back({row, static_cast<Index>(i), state.wrap});
  }
  return hidden;
}

IdentifiedFilter::IdentifiedFilter(const Identification& identification, VectorXd p, const Dataset& logs)
    : identification_(identification), p_(std::move(p)) {
  const PlantConfig& plant = identification.plant;
  output_wraps_.resize(static_cast<Index>(plant.output_names.size()));
  for (const std::string& output : plant.output_names) {
    const Index row = logged_row(logs.outputs, output);
    output_wraps_[static_cast<Index>(output_rows_.size())] = logs.outputs[static_cast<std::size_t>(row)].wrap;
    output_rows_.push_back(row);
  }
  for (const std::string& input : plant.inputs) input_rows_.push_back(logged_row(logs.inputs, input));
  state_wraps_ = VectorXd::Zero(static_cast<Index>(plant.states.size()));
  for (const Channel& state : logs.states) {
    state_rows_.push_back(state_row(plant, state.name));
    state_wraps_[state_rows_.back()] = state.wrap;
  }
  hidden_ = hidden_angles(identification, logs.states);
  if (hidden_.empty()) return;
  // Starts around one angle; largest number of starts (at least two for each angle).
  constexpr double kAround = 16.0, kMost = 64.0;
  const double each = std::floor(std::pow(kMost, 1.0 / static_cast<double>(hidden_.size())));
  around_ = static_cast<Index>(std::clamp(each, 2.0, kAround));
}

Index IdentifiedFilter::members() const {
  Index count = 1;
  for (std::size_t i = 0; i < hidden_.size(); ++i) count *= around_;
  return count;
}

LanePlant IdentifiedFilter::make_plant() const {
  const auto plant = std::make_shared<ParametricPlant>(identification_.plant);
  plant->set_parameters(p_);
  const auto by_point = [plant](Index rows, auto&& value) -> LanePlant::Map {
    return [plant, rows, value](const MatrixXd& x, const MatrixXd& u) {
      MatrixXd result(rows, x.cols());
      for (Index i = 0; i < x.cols(); ++i)
        result.col(i) = value(*plant, x.col(i), u.size() == 0 ? VectorXd() : VectorXd(u.col(i)));
      return result;
    };
  };
  LanePlant known;
  known.nx = plant->nx();
  known.ny = plant->ny();
  known.f = by_point(known.nx, [](auto& p, const VectorXd& x, const VectorXd& u) { return p.derivative(x, u); });
  known.h = by_point(known.ny, [](auto& p, const VectorXd& x, const VectorXd& u) { return p.output(x, u); });
  known.output_wraps = output_wraps_;
  known.state_wraps = state_wraps_;
  if (identification_.identify.longest_step_s > 0.0) known.longest_step_s = identification_.identify.longest_step_s;
  return known;
}

VectorXd IdentifiedFilter::tuning() const {
  std::vector<double> values;
  for (const double noise : identification_.identify.process_noise)
    if (noise > 0.0) values.push_back(std::log10(noise));
  for (const std::string& output : identification_.plant.output_names)
    values.push_back(std::log10(noise_of(identification_, output)));
  values.push_back(0.0);
  return as_vector(values);
}

FilterKnowledge IdentifiedFilter::knowledge(const VectorXd& tuning) const {
  const IdentifyConfig& identify = identification_.identify;
  FilterKnowledge known;
  known.initial_state = as_vector(identify.initial_state);
  known.process_deviation = VectorXd::Zero(known.initial_state.size());
  known.process_noise = as_vector(identify.process_noise);
  Index next = 0;
  for (double& noise : known.process_noise)
    if (noise > 0.0) noise = std::pow(10.0, tuning[next++]);
  const auto ny = static_cast<Index>(identification_.plant.output_names.size());
  known.output_deviation.resize(ny);
  for (double& deviation : known.output_deviation) deviation = std::pow(10.0, tuning[next++]);
  VectorXd deviation = std::pow(10.0, tuning[next]) * as_vector(identify.initial_deviation);
  for (const HiddenAngle& angle : hidden_)  // initial deviation of each filter: half of the distance between two starts
    deviation[angle.state] = 0.5 * angle.wrap / static_cast<double>(around_);
  known.initial_covariance = deviation.cwiseAbs2().asDiagonal();
  return known;
}

std::string IdentifiedFilter::describe(const VectorXd& tuning) const {
  const FilterKnowledge tuned = knowledge(tuning);
  std::string text = "process noise";
  for (const double noise : tuned.process_noise) text += " " + significant(noise, 2);
  text += " per sqrt(s), output noise";
  for (const double deviation : tuned.output_deviation) text += " " + significant(deviation, 2);
  text += fmt::format(", initial deviation x {}", significant(std::pow(10.0, tuning[tuning.size() - 1]), 2));
  for (const HiddenAngle& angle : hidden_)
    text += fmt::format(", {} starts around {}", around_,
                        identification_.plant.states[static_cast<std::size_t>(angle.state)]);
  return text + (hidden_.empty() ? "" : ": one filter from each, weighted by its innovations");
}

MatrixXd IdentifiedFilter::starts(const Trajectory& run) const {
  const PlantConfig& named = identification_.plant;
  VectorXd start = as_vector(identification_.identify.initial_state);
  for (std::size_t i = 0; i < named.states.size(); ++i)
    for (std::size_t j = 0; j < named.output_names.size(); ++j)
      if (named.states[i] == named.output_names[j]) start[static_cast<Index>(i)] = run.outputs(output_rows_[j], 0);
  MatrixXd all = start.replicate(1, members());
  for (Index b = 0; b < all.cols(); ++b)
    for (Index place = b, i = 0; i < static_cast<Index>(hidden_.size()); ++i, place /= around_) {
      const HiddenAngle& angle = hidden_[static_cast<std::size_t>(i)];
      all(angle.state, b) += angle.wrap * static_cast<double>(place % around_) / static_cast<double>(around_);
    }
  return all;
}

MatrixXd IdentifiedFilter::estimate(PointSet kind, const VectorXd& tuning, const Trajectory& run) const {
  return estimate_from(starts(run), kind, tuning, run);
}

MatrixXd IdentifiedFilter::estimate_from_nearest(PointSet kind, const VectorXd& tuning, const Trajectory& run) const {
  const MatrixXd all = starts(run);
  VectorXd distance = VectorXd::Zero(all.cols());
  for (const HiddenAngle& angle : hidden_)
    for (Index b = 0; b < all.cols(); ++b)
      distance[b] += std::abs(wrap_difference(all(angle.state, b) - run.states(angle.log_row, 0), angle.wrap));
  Index nearest = 0;
  distance.minCoeff(&nearest);
  return estimate_from(all.col(nearest), kind, tuning, run);
}

MatrixXd IdentifiedFilter::estimate_from(const MatrixXd& starts, PointSet kind, const VectorXd& tuning,
                                         const Trajectory& run) const {
  FilterKnowledge known = knowledge(tuning);
  const PlantConfig& named = identification_.plant;
  for (std::size_t i = 0; i < named.states.size(); ++i)
    for (std::size_t j = 0; j < named.output_names.size(); ++j)
      if (const auto row = static_cast<Index>(i); named.states[i] == named.output_names[j])
        known.initial_covariance(row, row) = std::pow(known.output_deviation[static_cast<Index>(j)], 2);
  FilterBank bank(make_plant(), kind, known, starts, {FilterTuning{}}, 1);
  const MatrixXd inputs = input_rows_.empty() ? MatrixXd() : rows_of(run.inputs, input_rows_);
  const bool held = identification_.identify.input_hold == Hold::kZeroOrder;
  return rows_of(filtered(bank, one_run(rows_of(run.outputs, output_rows_), inputs, run.time_s, held)).x_hat,
                 state_rows_);
}

StepCost IdentifiedFilter::step_cost(PointSet kind, double period_s) const {
  const PlantConfig& plant = identification_.plant;
  const double longest_s = identification_.identify.longest_step_s;
  const auto n = static_cast<double>(plant.states.size()), ny = static_cast<double>(plant.outputs.size());
  const StepCost one = sigma_point_cost(n, ny, kind == PointSet::kExtended, plant_cost(plant),
                                        longest_s > 0.0 ? rk4_steps(period_s, longest_s) : 1.0);
  return hidden_.empty() ? one : bank_cost(static_cast<double>(members()), n, ny, one);
}

}  // namespace nlo::trainer
