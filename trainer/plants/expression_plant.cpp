// SPDX-License-Identifier: MIT
#include "trainer/plants/expression_plant.h"

#include <fmt/format.h>
#include <muParser.h>

#include <set>

#include "codegen/error.h"
#include "codegen/identifier.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kLongestExpression = 4000;  // muParser gives up at 5,000 characters, without saying which

std::vector<codegen::Channel> named_channels(const std::vector<std::string>& names,
                                             const std::vector<std::string>& units, std::string_view what) {
  if (!units.empty() && units.size() != names.size())
    throw codegen::Error(
        fmt::format("[plant] has {} {} but {} units; give one unit for each", names.size(), what, units.size()));
  std::vector<codegen::Channel> result;
  for (std::size_t i = 0; i < names.size(); ++i) result.push_back({names[i], units.empty() ? "" : units[i], 0.0});
  return result;
}

void check_counts(const PlantConfig& config) {
  if (config.states.empty())
    throw codegen::Error("[plant] names neither a model nor states; give `model`, or states, derivative, outputs");
  if (config.derivative.size() != config.states.size())
    throw codegen::Error(fmt::format("[plant] has {} states but {} derivative expressions; give one for each",
                                     config.states.size(), config.derivative.size()));
  if (config.outputs.empty()) throw codegen::Error("[plant] has no outputs; give at least one expression");
  if (!config.output_names.empty() && config.output_names.size() != config.outputs.size())
    throw codegen::Error(fmt::format("[plant] has {} outputs but {} output_names; give one for each",
                                     config.outputs.size(), config.output_names.size()));
}

void check_names(const PlantConfig& config) {
  std::set<std::string> seen;
  const auto check = [&](const std::string& name, std::string_view what) {
    if (!codegen::is_identifier(name))
      throw codegen::Error(fmt::format(
          "[plant] {} \"{}\" is no identifier; use a letter, then letters, digits and single underscores", what, name));
    if (!seen.insert(name).second)
      throw codegen::Error(fmt::format("[plant] uses the name \"{}\" twice; rename one", name));
  };
  for (const std::string& name : config.states) check(name, "state");
  for (const auto& parameter : config.parameters) check(parameter.first, "parameter");
}

std::vector<std::string> output_names(const PlantConfig& config) {
  if (!config.output_names.empty()) return config.output_names;
  if (config.outputs.size() == 1) return {"y"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < config.outputs.size(); ++i) names.push_back(fmt::format("y{}", i + 1));
  return names;
}

/// muParser reads "x1 = 2" as an assignment to the state; an equation has no place here.
bool assigns(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) {
      return true;
    }
  }
  return false;
}

}  // namespace

/// Expressions over the columns of x. muParser reads its variables through pointers, so a state is copied in first.
class ExpressionPlant::Formulas {
 public:
  Formulas(const PlantConfig& config, const std::vector<std::string>& expressions, std::string_view key)
      : x_(config.states.size()), parsers_(expressions.size()) {
    for (std::size_t i = 0; i < expressions.size(); ++i)
      compile(parsers_[i], config, expressions[i], fmt::format("[plant] {}[{}]", key, i));
  }

  Eigen::MatrixXd evaluate(const Eigen::MatrixXd& x) {
    Eigen::MatrixXd result(static_cast<Eigen::Index>(parsers_.size()), x.cols());
    for (Eigen::Index column = 0; column < x.cols(); ++column) {
      Eigen::VectorXd::Map(x_.data(), x.rows()) = x.col(column);
      for (std::size_t i = 0; i < parsers_.size(); ++i)
        result(static_cast<Eigen::Index>(i), column) = parsers_[i].Eval();
    }
    return result;
  }

 private:
  void compile(mu::Parser& parser, const PlantConfig& config, const std::string& expression, const std::string& where) {
    const auto fail = [&](const std::string& what) {
      throw codegen::Error(fmt::format("{} \"{}\": {}", where, expression, what));
    };
    if (expression.find_first_not_of(" \t\n") == std::string::npos)
      fail("the expression is empty; write a number, or a name");
    if (expression.size() > kLongestExpression)
      throw codegen::Error(
          fmt::format("{} has {} characters; {} are the most", where, expression.size(), kLongestExpression));
    if (assigns(expression)) fail("\"=\" has no place in an expression; give only the right-hand side, compare by ==");
    try {
      parser.ClearConst();  // muParser's own _pi and _e
      if (!uses_name(config, "pi")) parser.DefineConst("pi", 3.141592653589793);
      for (std::size_t i = 0; i < config.states.size(); ++i) parser.DefineVar(config.states[i], &x_[i]);
      for (const auto& [name, value] : config.parameters) parser.DefineConst(name, value);
      parser.SetExpr(expression);
      int values = 0;
      parser.Eval(values);
      if (values != 1) fail(fmt::format("it has {} values, separated by commas; give one", values));
    } catch (const mu::ParserError& error) {
      const auto position = error.GetPos() < 0 ? std::string() : fmt::format(" at position {}", error.GetPos() + 1);
      fail(fmt::format("{}{}; states: {}; functions as in C (sin, exp, ...), powers by ^", error.GetMsg(), position,
                       fmt::join(config.states, ", ")));
    }
  }

  static bool uses_name(const PlantConfig& config, std::string_view name) {
    for (const std::string& state : config.states)
      if (state == name) return true;
    for (const auto& parameter : config.parameters)
      if (parameter.first == name) return true;
    return false;
  }

  std::vector<double> x_;  ///< n_x; the parsers hold pointers into it
  std::vector<mu::Parser> parsers_;
};

ExpressionPlant::ExpressionPlant(const PlantConfig& config)
    : Plant("expressions", named_channels(config.states, config.state_units, "states"),
            named_channels(output_names(config), config.output_units, "outputs")) {
  check_counts(config);
  check_names(config);
  for (std::size_t i = 0; i < outputs().size(); ++i) {
    if (!codegen::is_identifier(outputs()[i].name))
      throw codegen::Error(fmt::format("[plant] output name \"{}\" is no identifier", outputs()[i].name));
    for (std::size_t j = 0; j < i; ++j)
      if (outputs()[i].name == outputs()[j].name)
        throw codegen::Error(fmt::format("[plant] output_names has \"{}\" twice; rename one", outputs()[i].name));
  }
  derivative_ = std::make_unique<Formulas>(config, config.derivative, "derivative");
  output_ = std::make_unique<Formulas>(config, config.outputs, "outputs");
}

ExpressionPlant::~ExpressionPlant() = default;

Eigen::MatrixXd ExpressionPlant::derivative(const Eigen::MatrixXd& x) const {
  return derivative_->evaluate(x);
}

Eigen::MatrixXd ExpressionPlant::output(const Eigen::MatrixXd& x) const {
  return output_->evaluate(x);
}

}  // namespace nlo::trainer
