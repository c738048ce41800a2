// SPDX-License-Identifier: MIT
#include "trainer/plants/state_feedback.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "codegen/base/error.h"
#include "trainer/plants/plant_expression.h"

namespace nlo::trainer {

/// Expressions over the states of the plant and one more number for each input. It cannot be moved, because the parsers
/// point at the values.
class LoopExpressions {
 public:
  using NameOfInput = std::string (*)(const std::string& input);

  /// `where` is the place of a text for messages, with its index if it is a list.
  LoopExpressions(const std::vector<std::string>& texts, const std::string& where, const Plant& plant,
                  const PlantParameters& constants, NameOfInput name_of)
      : texts_(texts), where_(where) {
    ExpressionNames names{.variables = {}, .constants = constants};
    for (const auto& state : plant.states()) names.variables.push_back(state.name);
    for (const auto& input : plant.inputs()) names.variables.push_back(name_of(input.name));
    values_.resize(names.variables.size(), 0.0);
    for (std::size_t j = 0; j < texts_.size(); ++j)
      compile_expression(parsers_.emplace_back(), texts_[j], fmt::format(fmt::runtime(where_), j), names,
                         values_.data());
  }

  /// Returns true if text j uses a name.
  bool reads(std::size_t j, const std::string& name) const { return parsers_[j].GetUsedVar().contains(name); }

  Eigen::VectorXd evaluate(const Eigen::VectorXd& x, const Eigen::VectorXd& of_inputs) {
    Eigen::VectorXd::Map(values_.data(), static_cast<Eigen::Index>(values_.size())) << x, of_inputs;
    Eigen::VectorXd result(static_cast<Eigen::Index>(parsers_.size()));
    for (std::size_t j = 0; j < parsers_.size(); ++j) {
      const double value = parsers_[j].Eval();
      if (!std::isfinite(value))
        throw codegen::Error(
            fmt::format("{} \"{}\" is not a finite number at an estimate of the loop; write an expression that is "
                        "finite at all states",
                        fmt::format(fmt::runtime(where_), j), texts_[j]));
      result(static_cast<Eigen::Index>(j)) = value;
    }
    return result;
  }

 private:
  std::vector<std::string> texts_;
  std::string where_;
  std::vector<double> values_;
  std::deque<mu::Parser> parsers_;
};

std::string reference_name(const std::string& input) {
  return "r_" + input;
}

bool in_closed_loop(const FeedbackConfig& feedback, Eigen::Index run) {
  const auto before = static_cast<double>(run);
  return std::floor((before + 1.0) * feedback.share) > std::floor(before * feedback.share);
}

StateFeedback::StateFeedback(const FeedbackConfig& feedback, const Plant& plant, const PlantConfig& config)
    : laws_(std::make_unique<LoopExpressions>(feedback.law, "[feedback] law[{}]", plant, config.parameters,
                                              reference_name)),
      x_hat_(Eigen::VectorXd::Zero(plant.nx())),
      low_(Eigen::VectorXd::Map(feedback.actuator_low.data(), static_cast<Eigen::Index>(feedback.actuator_low.size()))),
      high_(Eigen::VectorXd::Map(feedback.actuator_high.data(),
                                 static_cast<Eigen::Index>(feedback.actuator_high.size()))) {
  const std::vector<codegen::Channel>& states = plant.states();
  const auto row_of = [&](const std::string& name) {
    return std::find_if(states.begin(), states.end(), [&](const auto& state) { return state.name == name; }) -
           states.begin();
  };
  for (const std::string& name : config.estimated) rows_.push_back(row_of(name));
  for (Eigen::Index i = 0; config.estimated.empty() && i < plant.nx(); ++i) rows_.push_back(i);
  for (std::size_t j = 0; j < feedback.law.size(); ++j)
    for (Eigen::Index i = 0; i < plant.nx(); ++i) {
      const std::string& name = states[static_cast<std::size_t>(i)].name;
      if (std::find(rows_.begin(), rows_.end(), i) == rows_.end() && laws_->reads(j, name))
        throw codegen::Error(
            fmt::format("[feedback] law[{}] \"{}\" reads {}, which the observer does not estimate: name it in [plant] "
                        "estimated, or write the law over {}",
                        j, feedback.law[j], name, fmt::join(config.estimated, ", ")));
    }
}

StateFeedback::~StateFeedback() = default;

Eigen::VectorXd StateFeedback::operator()(const Eigen::VectorXd& x_hat, const Eigen::VectorXd& reference) {
  x_hat_(rows_) = x_hat;
  return clipped(laws_->evaluate(x_hat_, reference));
}

Eigen::VectorXd StateFeedback::clipped(const Eigen::VectorXd& u) const {
  return u.cwiseMax(low_).cwiseMin(high_);
}

LoopCost::LoopCost(const FeedbackConfig& feedback, const Plant& plant, const PlantParameters& constants)
    : expression_(std::make_unique<LoopExpressions>(std::vector{feedback.cost}, "[feedback] cost", plant, constants,
                                                    [](const std::string& input) { return input; })) {}

LoopCost::~LoopCost() = default;

double LoopCost::operator()(const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
  return expression_->evaluate(x, u)(0);
}

}  // namespace nlo::trainer
