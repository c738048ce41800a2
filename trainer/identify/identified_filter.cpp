// SPDX-License-Identifier: MIT
#include "trainer/identify/identified_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "trainer/evaluation/text.h"
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

double noise_of(const Identification& identification, const std::string& output) {
  for (const auto& [name, deviation] : identification.identify.noise)
    if (name == output) return deviation;
  return 1.0;  // checked: every output has one
}

}  // namespace

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
  for (const Channel& state : logs.states)
    state_rows_.push_back(std::find(plant.states.begin(), plant.states.end(), state.name) - plant.states.begin());
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
  const VectorXd deviation = std::pow(10.0, tuning[next]) * as_vector(identify.initial_deviation);
  known.initial_covariance = deviation.cwiseAbs2().asDiagonal();
  return known;
}

std::string IdentifiedFilter::describe(const VectorXd& tuning) const {
  const FilterKnowledge tuned = knowledge(tuning);
  std::string text = "process noise";
  for (const double noise : tuned.process_noise) text += " " + significant(noise, 2);
  text += " per sqrt(s), output noise";
  for (const double deviation : tuned.output_deviation) text += " " + significant(deviation, 2);
  return text + fmt::format(", initial deviation x {}", significant(std::pow(10.0, tuning[tuning.size() - 1]), 2));
}

MatrixXd IdentifiedFilter::estimate(PointSet kind, const VectorXd& tuning, const Trajectory& run) const {
  FilterKnowledge known = knowledge(tuning);
  const PlantConfig& named = identification_.plant;
  for (std::size_t i = 0; i < named.states.size(); ++i)
    for (std::size_t j = 0; j < named.output_names.size(); ++j)
      if (named.states[i] == named.output_names[j]) {  // a state that is measured begins where it is measured
        const auto row = static_cast<Index>(i);
        known.initial_state[row] = run.outputs(output_rows_[j], 0);
        known.initial_covariance(row, row) = std::pow(known.output_deviation[static_cast<Index>(j)], 2);
      }
  SigmaPointFilter filter(make_plant(), kind, known, {FilterTuning{}}, 1);
  const MatrixXd inputs = input_rows_.empty() ? MatrixXd() : rows_of(run.inputs, input_rows_);
  const bool held = identification_.identify.input_hold == Hold::kZeroOrder;
  return rows_of(filtered(filter, one_run(rows_of(run.outputs, output_rows_), inputs, run.time_s, held)).x_hat,
                 state_rows_);
}

StepCost IdentifiedFilter::step_cost(PointSet kind, double period_s) const {
  const PlantConfig& plant = identification_.plant;
  const double longest_s = identification_.identify.longest_step_s;
  return sigma_point_cost(static_cast<double>(plant.states.size()), static_cast<double>(plant.outputs.size()),
                          kind == PointSet::kExtended, plant_cost(plant),
                          longest_s > 0.0 ? rk4_steps(period_s, longest_s) : 1.0);
}

}  // namespace nlo::trainer
