// SPDX-License-Identifier: MIT
// Conditions for the comparison of observers and filters: sensors, plants and initial states that differ from the
// training. They are read from a TOML file of [[condition]] tables.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// [[condition]]
struct Condition {
  std::string name = {};
  NoiseConfig noise = {};
  /// Factor for one parameter in each run. Successive runs change successive parameters, because a factor for all of
  /// them may cancel, as in g / l.
  double parameter_factor = 1.0;
  std::vector<std::pair<std::string, double>> parameters = {};  ///< parameters of the plant, by name
  std::vector<double> process_noise = {};  ///< per sqrt(s), one for each state or one for all; empty: none
  double box_scale = 1.0;                  ///< scales the box of initial states of the training
  /// Changes of the tested plant: plant., simulation., excitation. or feedback.KEY=VALUE.
  std::vector<std::string> changes = {};
  std::vector<std::string> inputs = {};  ///< excitation of the plant, see parse_excitation; empty: its [excitation]
  NoiseConfig input_noise = {};          ///< noise of the inputs that estimators get; the plant has them without it
  std::string place = {};                ///< FILE:LINE

  bool changes_parameters() const { return parameter_factor != 1.0 || !parameters.empty(); }
};

/// A set of conditions. A set for any plant has the scales for which its numbers were chosen (written_for_...), and
/// conditions_of() converts them to the plant. 0: the numbers are in the units of the plant.
struct ConditionSet {
  double written_for_deviation = 0.0;  ///< deviation of outputs and states; scales outliers, clipping, process noise
  double written_for_noise = 0.0;      ///< deviation of a sensor's noise in training; scales noise, bias, quantisation
  std::vector<Condition> conditions;
};

/// Scales of a plant's channels, each a standard deviation.
struct ChannelScales {
  Eigen::VectorXd outputs, states;  ///< over nominal runs
  Eigen::VectorXd noise;            ///< noise of each output's sensor in training; 0: trained without noise
};

/// Parses a file of conditions. Throws codegen::Error `FILE:LINE: reason; remedy`.
ConditionSet parse_conditions(std::string_view text, const std::string& filename);
ConditionSet read_conditions(const std::string& path);

/// Returns the conditions that are used without a file.
const ConditionSet& default_conditions();

/// Returns value times the number of 1, 2, 5, 10, ... that is nearest to `factor`, so that scaled numbers stay round.
double round_factor(double factor);

/// Returns the conditions in the units of a plant with the nominal `parameters`. A condition on parameters is an error
/// for a plant without parameters, but in a set for any plant it is left out and named in `left_out`. A parameter or a
/// number of channels that the plant does not have is also an error. A sensor that was trained without noise gets noise
/// in the scale of its output.
std::vector<Condition> conditions_of(const ConditionSet& set,
                                     const std::vector<std::pair<std::string, double>>& parameters,
                                     const ChannelScales& scales, std::vector<std::string>& left_out);

/// Returns the parameters of the plant under a condition in run `run`.
std::vector<std::pair<std::string, double>> changed_parameters(
    const Condition& condition, const std::vector<std::pair<std::string, double>>& nominal, std::size_t run);

/// Returns a title for readers: "N(0, 0.5), parameters x 1.2".
std::string condition_title(const Condition& condition);

}  // namespace nlo::trainer
