// SPDX-License-Identifier: MIT
#include "trainer/plants/excitation.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "codegen/base/error.h"
#include "trainer/plants/plant_expression.h"

namespace nlo::trainer {
namespace {

/// One expression over t. It cannot be moved, because the parser points at the time.
class TimeFunction {
 public:
  TimeFunction(std::string where, std::string text) : where_(std::move(where)), text_(std::move(text)) {
    compile_expression(parser_, text_, where_, {.variables = {"t"}}, &time_s_);
  }
  TimeFunction(const TimeFunction&) = delete;
  TimeFunction& operator=(const TimeFunction&) = delete;

  double operator()(double time_s) {
    time_s_ = time_s;
    const double value = parser_.Eval();
    if (!std::isfinite(value))
      throw codegen::Error(fmt::format(
          "{} \"{}\" is not a finite number at t = {:.6g} s; write an expression that is finite at all times", where_,
          text_, time_s));
    return value;
  }

 private:
  std::string where_, text_;
  double time_s_ = 0.0;
  mu::Parser parser_;
};

}  // namespace

Excitation parse_excitation(const Plant& plant, const std::vector<std::string>& expressions) {
  if (expressions.empty()) return nullptr;
  const auto& inputs = plant.inputs();
  if (inputs.empty())
    throw codegen::Error(fmt::format("plant {} has no input to excite; leave --input out", plant.name()));
  if (expressions.size() != inputs.size()) {
    std::string names;
    for (const auto& input : inputs) names += (names.empty() ? "" : ", ") + input.name;
    throw codegen::Error(
        fmt::format("plant {} has {} input{} ({}), but --input gives {}; give one expression for each, in this order",
                    plant.name(), inputs.size(), inputs.size() == 1 ? "" : "s", names, expressions.size()));
  }
  std::vector<std::shared_ptr<TimeFunction>> functions;
  for (std::size_t j = 0; j < inputs.size(); ++j)
    functions.push_back(std::make_shared<TimeFunction>("input " + inputs[j].name, expressions[j]));
  return [functions = std::move(functions)](double time_s) {
    Eigen::VectorXd u(static_cast<Eigen::Index>(functions.size()));
    for (std::size_t j = 0; j < functions.size(); ++j) u(static_cast<Eigen::Index>(j)) = (*functions[j])(time_s);
    return u;
  };
}

std::vector<std::pair<std::string, std::string>> name_expressions(const Plant& plant,
                                                                  const std::vector<std::string>& expressions) {
  std::vector<std::pair<std::string, std::string>> result;
  for (std::size_t j = 0; j < expressions.size(); ++j) result.emplace_back(plant.inputs().at(j).name, expressions[j]);
  return result;
}

}  // namespace nlo::trainer
