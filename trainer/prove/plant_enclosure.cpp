// SPDX-License-Identifier: MIT
#include "trainer/prove/plant_enclosure.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/model/expression_derivative.h"
#include "trainer/plants/equations_of_plant.h"

namespace nlo::trainer {
namespace {

using codegen::Expression;

void check_slopes(const Expression& expression, const std::string& text) {
  for (const Expression::Node& node : expression.nodes()) {
    if (node.kind == Expression::Kind::kMinimum || node.kind == Expression::Kind::kMaximum)
      throw codegen::Error(
          fmt::format("the proof needs continuous slopes, but the plant's expression \"{}\" has min or max", text));
    if (node.kind == Expression::Kind::kFunction &&
        (node.function == codegen::Function::kRoot || node.function == codegen::Function::kSign))
      throw codegen::Error(fmt::format(
          "the proof needs bounded slopes, but the plant's expression \"{}\" has {}, whose slope is unbounded at 0",
          text, codegen::row_of(node.function).name));
  }
}

/// Returns dq/dx f.
Expression rate_of(const Expression& q, const std::vector<Expression>& f) {
  codegen::ExpressionNodes sum;
  for (std::size_t j = 0; j < f.size(); ++j)
    sum = codegen::sum(std::move(sum), codegen::product(codegen::derivative(q, static_cast<int>(j)), f[j].nodes()));
  return codegen::expression_of(std::move(sum));
}

}  // namespace

PlantEnclosure::PlantEnclosure(const PlantConfig& given) {
  const PlantConfig plant = equations_of(given);
  nx_ = static_cast<Eigen::Index>(plant.states.size());
  ny_ = static_cast<Eigen::Index>(plant.outputs.size());
  std::vector<std::string> names = plant.states;
  names.insert(names.end(), plant.inputs.begin(), plant.inputs.end());
  constants_.assign(plant.inputs.size(), 0.0);
  for (const auto& [name, value] : plant.parameters) {
    names.push_back(name);
    constants_.push_back(value);
  }
  std::vector<Expression> all;
  const auto parse = [&](const std::vector<std::string>& texts) {
    std::vector<Expression> parsed;
    for (const std::string& text : texts) {
      parsed.emplace_back(text, names, Expression::Language::kFunctions);
      check_slopes(parsed.back(), text);
    }
    return parsed;
  };
  const auto add = [&](const std::vector<Expression>& rows, bool with_slopes) {
    all.insert(all.end(), rows.begin(), rows.end());
    for (int j = 0; with_slopes && j < nx_; ++j)
      for (const Expression& row : rows) all.push_back(codegen::expression_of(codegen::derivative(row, j)));
  };
  const std::vector<Expression> f = parse(plant.derivative);
  std::vector<Expression> rates = parse(plant.outputs);
  std::vector<Expression> functions = f;
  add(f, true);
  for (std::size_t i = 0; i < PlantRanges::kRates; ++i) {
    const bool last = i + 1 == PlantRanges::kRates;
    add(rates, !last);
    if (!last) functions.insert(functions.end(), rates.begin(), rates.end());
    for (std::size_t j = 0; j < rates.size() && !last; ++j) rates[j] = rate_of(rates[j], f);
  }
  functions_ = codegen::SharedExpressions(functions, static_cast<int>(names.size()));
  rows_ = codegen::SharedExpressions(all, static_cast<int>(names.size()));
}

PlantRanges PlantEnclosure::over(const StateBox& box) const {
  std::vector<Interval> values(rows_.rows.size());
  rows_.evaluate<Interval>(
      [&](int j) {
        if (j >= nx_) return Interval(constants_[static_cast<std::size_t>(j - nx_)]);
        return around(box.centre(j), box.radius(j));
      },
      values.data());
  std::size_t at = 0;
  const auto take = [&](Eigen::Index rows, Eigen::Index cols) {
    IntervalMatrix ranges(rows, cols);
    for (Eigen::Index j = 0; j < cols; ++j)
      for (Eigen::Index i = 0; i < rows; ++i) ranges(i, j) = values[at++];
    return ranges;
  };
  PlantRanges result;
  result.f = take(nx_, 1);
  result.f_slopes = take(nx_, nx_);
  for (std::size_t i = 0; i < PlantRanges::kRates; ++i) {
    result.rates[i] = take(ny_, 1);
    if (i + 1 < PlantRanges::kRates) result.rate_slopes[i] = take(ny_, nx_);
  }
  return result;
}

std::vector<TaylorModel> PlantEnclosure::models_over(const StateBox& box) const {
  std::vector<TaylorModel> values(functions_.rows.size());
  functions_.evaluate<TaylorModel>(
      [&](int j) {
        if (j >= nx_) return TaylorModel(constants_[static_cast<std::size_t>(j - nx_)]);
        return TaylorModel::variable(static_cast<std::size_t>(j), box.centre(j), box.radius(j));
      },
      values.data());
  return values;
}

}  // namespace nlo::trainer
