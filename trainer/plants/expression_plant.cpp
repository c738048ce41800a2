// SPDX-License-Identifier: MIT
#include "trainer/plants/expression_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <set>

#include "codegen/base/identifier.h"
#include "trainer/config/key_error.h"
#include "trainer/plants/plant_expression.h"

namespace nlo::trainer {
namespace {

std::vector<codegen::Channel> named_channels(const std::vector<std::string>& names,
                                             const std::vector<std::string>& units, const std::vector<double>& wraps,
                                             std::string_view key, std::string_view what) {
  if (!units.empty() && units.size() != names.size())
    throw KeyError("plant", fmt::format("[plant] has {} {} but {} units; give one unit for each", names.size(), what,
                                        units.size()));
  if (!wraps.empty() && wraps.size() != names.size())
    throw KeyError(
        fmt::format("plant.{}_wraps", key),
        fmt::format(
            "[plant] {}_wraps has {} entries, but there are {} {}; give one for each, and 0 if it is not an angle", key,
            wraps.size(), names.size(), what));
  std::vector<codegen::Channel> result;
  for (std::size_t i = 0; i < names.size(); ++i)
    result.push_back({names[i], units.empty() ? "" : units[i], wraps.empty() ? 0.0 : wraps[i]});
  return result;
}

void check_counts(const PlantConfig& config) {
  if (config.states.empty())
    throw KeyError("plant", "[plant] has neither a model nor states; give `model`, or states, derivative and outputs");
  if (config.derivative.size() != config.states.size())
    throw KeyError("plant", fmt::format("[plant] has {} states but {} derivative expressions; give one for each",
                                        config.states.size(), config.derivative.size()));
  if (config.outputs.empty()) throw KeyError("plant", "[plant] has no outputs; give at least one expression");
  if (!config.output_names.empty() && config.output_names.size() != config.outputs.size())
    throw KeyError("plant", fmt::format("[plant] has {} outputs but {} output_names; give one for each",
                                        config.outputs.size(), config.output_names.size()));
  if (config.inputs.empty() && config.input_field.empty()) return;
  if (config.inputs.empty())
    throw KeyError("plant.input_field",
                   "[plant] input_field needs inputs with names; give inputs = [\"u\"], one for each column");
  if (config.input_field.empty()) return;
  if (config.input_field.size() != config.states.size())
    throw KeyError("plant.input_field",
                   fmt::format("[plant] input_field has {} rows, but there are {} states; give a row for each",
                               config.input_field.size(), config.states.size()));
  for (std::size_t i = 0; i < config.input_field.size(); ++i)
    if (config.input_field[i].size() != config.inputs.size())
      throw KeyError("plant.input_field",
                     fmt::format("[plant] input_field[{}] has {} expressions, but there are {} inputs; give one for "
                                 "each, and \"0\" for an input without effect",
                                 i, config.input_field[i].size(), config.inputs.size()));
}

void check_names(const PlantConfig& config) {
  std::set<std::string> seen;
  const auto check = [&](const std::string& name, std::string_view what, std::string_view key) {
    if (!codegen::is_identifier(name))
      throw KeyError(
          fmt::format("plant.{}", key),
          fmt::format(
              "[plant] {} \"{}\" is not an identifier; use a letter, then letters, digits and single underscores", what,
              name));
    if (!seen.insert(name).second)
      throw KeyError("plant", fmt::format("[plant] uses the name \"{}\" twice; rename one", name));
  };
  for (const std::string& name : config.states) check(name, "state", "states");
  for (const std::string& name : config.inputs) check(name, "input", "inputs");
  for (const auto& parameter : config.parameters) check(parameter.first, "parameter", "parameters");
}

std::vector<std::string> output_names(const PlantConfig& config) {
  if (!config.output_names.empty()) return config.output_names;
  if (config.outputs.size() == 1) return {"y"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < config.outputs.size(); ++i) names.push_back(fmt::format("y{}", i + 1));
  return names;
}

}  // namespace

/// Expressions over the columns of x. muParser reads its variables through pointers, so a state is copied in first.
class ExpressionPlant::Formulas {
 public:
  /// Uses the states, then `inputs`; `hint` ends the message about an unknown name.
  explicit Formulas(const PlantConfig& config, const std::vector<std::string>& inputs = {}, std::string hint = {})
      : names_{.variables = config.states, .constants = config.parameters, .hint = std::move(hint)} {
    names_.variables.insert(names_.variables.end(), inputs.begin(), inputs.end());
    x_.resize(names_.variables.size());
  }

  /// Adds an expression of `key`, such as "outputs"; `index` is its place in the list, such as "[0]".
  void add(const std::string& expression, const std::string& key, const std::string& index) try {
    compile_expression(parsers_.emplace_back(), expression, fmt::format("[plant] {}{}", key, index), names_, x_.data());
  } catch (const codegen::Error& error) {
    throw KeyError("plant." + key, error.what());
  }

  /// Returns true if one of the expressions uses a variable.
  bool uses(const std::string& name) const {
    return std::any_of(parsers_.begin(), parsers_.end(),
                       [&](const mu::Parser& parser) { return parser.GetUsedVar().contains(name); });
  }

  /// Evaluates the expressions. u has one column for each column of x; if it is 0 x B, the inputs are 0.
  Eigen::MatrixXd evaluate(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u = {}) {
    Eigen::MatrixXd result(static_cast<Eigen::Index>(parsers_.size()), x.cols());
    std::fill(x_.begin(), x_.end(), 0.0);
    for (Eigen::Index column = 0; column < x.cols(); ++column) {
      Eigen::VectorXd::Map(x_.data(), x.rows()) = x.col(column);
      if (u.rows() > 0) Eigen::VectorXd::Map(x_.data() + x.rows(), u.rows()) = u.col(column);
      for (std::size_t i = 0; i < parsers_.size(); ++i)
        result(static_cast<Eigen::Index>(i), column) = parsers_[i].Eval();
    }
    return result;
  }

 private:
  ExpressionNames names_;
  std::vector<double> x_;           ///< n_x, and n_u if inputs are used; the parsers hold pointers into it
  std::deque<mu::Parser> parsers_;  ///< never moved, because a moved parser would be compiled again
};

ExpressionPlant::ExpressionPlant(const PlantConfig& config)
    : Plant("expressions", named_channels(config.states, config.state_units, config.state_wraps, "state", "states"),
            named_channels(output_names(config), config.output_units, config.output_wraps, "output", "outputs"),
            named_channels(config.inputs, config.input_units, {}, "input", "inputs")) {
  check_counts(config);
  check_names(config);
  for (std::size_t i = 0; i < outputs().size(); ++i) {
    if (!codegen::is_identifier(outputs()[i].name))
      throw KeyError("plant.output_names",
                     fmt::format("[plant] output name \"{}\" is not an identifier", outputs()[i].name));
    for (std::size_t j = 0; j < i; ++j)
      if (outputs()[i].name == outputs()[j].name)
        throw KeyError("plant.output_names",
                       fmt::format("[plant] output_names has \"{}\" twice; rename one", outputs()[i].name));
    for (const std::string& input : config.inputs)
      if (outputs()[i].name == input)
        throw KeyError("plant", fmt::format("[plant] uses \"{}\" for an input and an output; rename one", input));
  }
  const bool names_inputs = !config.inputs.empty() && config.input_field.empty();
  const std::string elsewhere =
      config.input_field.empty() ? "" : "; write inputs in input_field, or remove input_field and name the inputs here";
  derivative_ =
      std::make_unique<Formulas>(config, names_inputs ? config.inputs : std::vector<std::string>(), elsewhere);
  for (std::size_t i = 0; i < config.derivative.size(); ++i)
    derivative_->add(config.derivative[i], "derivative", fmt::format("[{}]", i));
  output_ = std::make_unique<Formulas>(
      config, config.outputs_read_inputs ? config.inputs : std::vector<std::string>(),
      config.inputs.empty() ? ""
                            : "; an output of a simulated plant is a function of the state alone; beside logs and with "
                              "[simulation] share = 0 it may depend on inputs");
  for (std::size_t i = 0; i < config.outputs.size(); ++i)
    output_->add(config.outputs[i], "outputs", fmt::format("[{}]", i));
  for (const std::string& input : config.inputs)
    if (names_inputs && !derivative_->uses(input) && !output_->uses(input))
      throw KeyError("plant.inputs",
                     fmt::format("[plant] the input \"{}\" has no effect; name it in a derivative expression, or give "
                                 "input_field, a row for each state and in it an expression for each input",
                                 input));
  for (std::size_t j = 0; j < config.inputs.size() && !names_inputs; ++j) {
    input_fields_.push_back(std::make_unique<Formulas>(config, std::vector<std::string>(),
                                                       "; an input field is a function of the state alone"));
    for (std::size_t i = 0; i < config.states.size(); ++i)
      input_fields_[j]->add(config.input_field[i][j], "input_field", fmt::format("[{}][{}]", i, j));
  }
}

ExpressionPlant::~ExpressionPlant() = default;

Eigen::MatrixXd ExpressionPlant::derivative(const Eigen::MatrixXd& x) const {
  return derivative_->evaluate(x);
}

Eigen::MatrixXd ExpressionPlant::driven_derivative(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) const {
  if (affine_in_inputs()) return Plant::driven_derivative(x, u);
  return derivative_->evaluate(x, u);
}

Eigen::MatrixXd ExpressionPlant::output(const Eigen::MatrixXd& x) const {
  return output_->evaluate(x);
}

Eigen::MatrixXd ExpressionPlant::input_field(const Eigen::MatrixXd& x, Eigen::Index input) const {
  if (!input_fields_.empty() || inputs().empty()) return input_fields_.at(static_cast<std::size_t>(input))->evaluate(x);
  Eigen::MatrixXd one = Eigen::MatrixXd::Zero(nu(), x.cols());
  one.row(input).setOnes();
  return derivative_->evaluate(x, one) - derivative_->evaluate(x);
}

}  // namespace nlo::trainer
