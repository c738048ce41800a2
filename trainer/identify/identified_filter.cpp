// SPDX-License-Identifier: MIT
#include "trainer/identify/identified_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "trainer/baselines/ekf.h"
#include "trainer/baselines/ukf.h"
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

FilterPlant IdentifiedFilter::make_plant() const {
  const auto plant = std::make_shared<ParametricPlant>(identification_.plant);
  plant->set_parameters(p_);
  const FilterPlant::DrivenMap driven = [plant](const MatrixXd& x, const VectorXd& u) {
    MatrixXd result(plant->nx(), x.cols());
    for (Index i = 0; i < x.cols(); ++i) result.col(i) = plant->derivative(x.col(i), u);
    return result;
  };
  const FilterPlant::DrivenMap output = [plant](const MatrixXd& x, const VectorXd& u) {
    MatrixXd result(plant->ny(), x.cols());
    for (Index i = 0; i < x.cols(); ++i) result.col(i) = plant->output(x.col(i), u);
    return result;
  };
  FilterPlant known{[driven](const MatrixXd& x) { return driven(x, VectorXd()); },
                    [output](const MatrixXd& x) { return output(x, VectorXd()); }, driven, output_wraps_, output};
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

FilterConfig IdentifiedFilter::config(const VectorXd& tuning) const {
  const IdentifyConfig& identify = identification_.identify;
  FilterConfig config;
  config.initial_state = as_vector(identify.initial_state);
  config.process_noise = as_vector(identify.process_noise);
  Index next = 0;
  for (double& noise : config.process_noise)
    if (noise > 0.0) noise = std::pow(10.0, tuning[next++]);
  const auto ny = static_cast<Index>(identification_.plant.output_names.size());
  config.output_variance.resize(ny);
  for (Index j = 0; j < ny; ++j) config.output_variance[j] = std::pow(10.0, 2.0 * tuning[next++]);
  const VectorXd deviation = std::pow(10.0, tuning[next]) * as_vector(identify.initial_deviation);
  config.initial_covariance = deviation.cwiseAbs2().asDiagonal();
  config.process_variance = 0.0;
  config.least_output_variance = 0.0;
  config.held_inputs = identify.input_hold == Hold::kZeroOrder;
  return config;
}

std::string IdentifiedFilter::describe(const VectorXd& tuning) const {
  const FilterConfig tuned = config(tuning);
  std::string text = "process noise";
  for (const double noise : tuned.process_noise) text += " " + significant(noise, 2);
  text += " per sqrt(s), output noise";
  for (const double variance : tuned.output_variance) text += " " + significant(std::sqrt(variance), 2);
  return text + fmt::format(", initial deviation x {}", significant(std::pow(10.0, tuning[tuning.size() - 1]), 2));
}

MatrixXd IdentifiedFilter::estimate(FilterKind kind, const VectorXd& tuning, const Trajectory& run) const {
  const auto plant = [this] { return make_plant(); };
  FilterConfig start = config(tuning);
  const PlantConfig& named = identification_.plant;
  for (std::size_t i = 0; i < named.states.size(); ++i)
    for (std::size_t j = 0; j < named.output_names.size(); ++j)
      if (named.states[i] == named.output_names[j]) {  // a state that is measured begins where it is measured
        const auto row = static_cast<Index>(i);
        start.initial_state[row] = run.outputs(output_rows_[j], 0);
        start.initial_covariance(row, row) = start.output_variance[static_cast<Index>(j)];
      }
  const EstimatorFactory factory =
      kind == FilterKind::kExtended ? ekf_estimator(plant, start) : ukf_estimator(plant, start);
  const MatrixXd inputs = input_rows_.empty() ? MatrixXd() : rows_of(run.inputs, input_rows_);
  return rows_of(factory()(rows_of(run.outputs, output_rows_), inputs, run.time_s), state_rows_);
}

}  // namespace nlo::trainer
