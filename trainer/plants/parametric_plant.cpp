// SPDX-License-Identifier: MIT
#include "trainer/plants/parametric_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <set>

#include "codegen/base/identifier.h"
#include "trainer/config/key_error.h"
#include "trainer/plants/plant_expression.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void fail(const std::string& key, const std::string& what) {
  throw KeyError(key.empty() ? "plant" : "plant." + key, "[plant] " + what);
}

void check(const PlantConfig& config) {
  if (!config.model.empty())
    fail("model", fmt::format("model = \"{}\" is built in, but identification needs expressions: write states, "
                              "derivative, outputs and parameters",
                              config.model));
  if (config.states.empty()) fail("", "has no states; name them: states = [\"x1\", \"x2\"]");
  if (config.derivative.size() != config.states.size())
    fail("derivative", fmt::format("has {} states but {} derivative expressions; give one for each",
                                   config.states.size(), config.derivative.size()));
  if (config.outputs.empty()) fail("", "has no outputs; give an expression for each measured column");
  if (config.output_names.size() != config.outputs.size())
    fail("output_names",
         fmt::format("has {} outputs but {} output_names; give one name for each: the name of its column in the logs",
                     config.outputs.size(), config.output_names.size()));
  if (!config.input_field.empty())
    fail("input_field", "input_field is not needed here; name the inputs in derivative and outputs");
  if (config.parameters.empty())
    fail("", "has no parameters to find; name them with starting values: parameters = { a = 1.0 }");
  std::set<std::string> seen;
  const auto check_name = [&](const std::string& name, const char* what, const char* key) {
    if (!codegen::is_identifier(name))
      fail(key, fmt::format("{} \"{}\" is not an identifier; use a letter, then letters, digits and single underscores",
                            what, name));
    if (!seen.insert(name).second) fail(key, fmt::format("uses the name \"{}\" twice; rename one", name));
  };
  for (const std::string& name : config.states) check_name(name, "state", "states");
  for (const std::string& name : config.inputs) check_name(name, "input", "inputs");
  for (const auto& parameter : config.parameters) check_name(parameter.first, "parameter", "parameters");
}

}  // namespace

/// muParser reads its variables through pointers: states, inputs and parameters are stored one after another in
/// `values`.
struct ParametricPlant::Formulas {
  std::vector<double> values;
  std::deque<mu::Parser> derivative, output;  ///< never moved, because a moved parser would be compiled again

  void add(std::deque<mu::Parser>& parsers, const std::string& text, const std::string& key,
           const ExpressionNames& names) {
    const std::string where = fmt::format("[plant] {}[{}]", key, parsers.size());
    try {
      compile_expression(parsers.emplace_back(), text, where, names, values.data());
    } catch (const codegen::Error& error) {
      throw KeyError("plant." + key, error.what());
    }
  }

  bool uses(const std::string& name) const {
    const auto used = [&](const mu::Parser& parser) { return parser.GetUsedVar().contains(name); };
    return std::any_of(derivative.begin(), derivative.end(), used) || std::any_of(output.begin(), output.end(), used);
  }

  Eigen::VectorXd evaluate(std::deque<mu::Parser>& parsers, const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
    std::copy(x.data(), x.data() + x.size(), values.data());
    std::copy(u.data(), u.data() + u.size(), values.data() + x.size());
    Eigen::VectorXd result(static_cast<Eigen::Index>(parsers.size()));
    for (std::size_t i = 0; i < parsers.size(); ++i) result[static_cast<Eigen::Index>(i)] = parsers[i].Eval();
    return result;
  }
};

ParametricPlant::ParametricPlant(const PlantConfig& config)
    : states_(config.states),
      outputs_(config.output_names),
      inputs_(config.inputs),
      formulas_(std::make_unique<Formulas>()) {
  check(config);
  for (const auto& [name, value] : config.parameters) parameters_.push_back(name);
  ExpressionNames names;
  for (const auto* group : {&states_, &inputs_, &parameters_})
    names.variables.insert(names.variables.end(), group->begin(), group->end());
  formulas_->values.resize(names.variables.size(), 0.0);
  for (std::size_t i = 0; i < parameters_.size(); ++i)
    formulas_->values[states_.size() + inputs_.size() + i] = config.parameters[i].second;
  for (const std::string& text : config.derivative) formulas_->add(formulas_->derivative, text, "derivative", names);
  for (const std::string& text : config.outputs) formulas_->add(formulas_->output, text, "outputs", names);
  for (const std::string& input : inputs_)
    if (!formulas_->uses(input))
      fail("inputs", fmt::format("the input \"{}\" has no effect; name it in an expression, or remove it", input));
  for (const std::string& parameter : parameters_)
    if (!formulas_->uses(parameter))
      fail("parameters",
           fmt::format("the parameter \"{}\" has no effect; name it in an expression, or remove it", parameter));
}

ParametricPlant::~ParametricPlant() = default;

void ParametricPlant::set_parameters(const Eigen::VectorXd& p) {
  std::copy(p.data(), p.data() + np(), formulas_->values.data() + nx() + nu());
}

Eigen::VectorXd ParametricPlant::parameter_values() const {
  return Eigen::VectorXd::Map(formulas_->values.data() + nx() + nu(), np());
}

Eigen::VectorXd ParametricPlant::derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
  return formulas_->evaluate(formulas_->derivative, x, u);
}

Eigen::VectorXd ParametricPlant::output(const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
  return formulas_->evaluate(formulas_->output, x, u);
}

}  // namespace nlo::trainer
