// SPDX-License-Identifier: MIT
#include "codegen/targets/error_limits.h"

#include <cmath>
#include <limits>
#include <utility>

#include "codegen/base/key_values.h"
#include "codegen/model/field_checks.h"
#include "codegen/targets/number_formats.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

double limit_of(const std::string& text) {
  const double limit = decimal(text);
  if (!(limit > 0.0) || !std::isfinite(limit))
    fail("--max-error: \"{}\" is not a limit; give a positive number, such as 0.01", text);
  return limit;
}

std::string named(const Channel& state) {
  return state.name + (state.unit.empty() ? "" : " [" + safe_comment(state.unit, 20) + "]");
}

}  // namespace

Eigen::VectorXd error_limits(const std::string& text, const Model& m) {
  if (text.find('=') == std::string::npos) return Eigen::VectorXd::Constant(m.nx(), limit_of(text));
  Eigen::VectorXd limits = Eigen::VectorXd::Constant(m.nx(), kFree);
  for (const auto& [key, value] : key_values(text, "--max-error")) {
    int state = 0;
    std::string known;
    for (; state < m.nx() && m.states[static_cast<std::size_t>(state)].name != key; ++state)
      known += (known.empty() ? "" : ", ") + m.states[static_cast<std::size_t>(state)].name;
    if (state == m.nx()) fail("--max-error: there is no state \"{}\"; the model estimates {}", key, known);
    limits(state) = limit_of(value);
  }
  return limits;
}

std::string samples_text(const ExportError& error) {
  const std::string count = grouped(error.samples) + " samples in its domain, ";
  if (error.recorded == 0) return count + "from synthetic tones, because no flight was recorded";
  if (error.recorded == error.samples) return count + "from flights that training recorded";
  return count + grouped(error.recorded) + " from flights that training recorded, the rest from synthetic tones";
}

std::string error_table(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const ExportOptions& options = prepared.options();
  const ExportError& error = prepared.error();
  std::string text =
      fmt::format("error of {} against the model's equations, over {}\n  {:<24}  {:>8}  {:>8}  {:>8}  {:>11}\n",
                  numbers_name(options), samples_text(error), "", "max", "99.9 %", "rms", "max outside");
  for (int i = 0; i < m.nx(); ++i)
    text += fmt::format("  {:<24}  {:>8.1e}  {:>8.1e}  {:>8.1e}  {:>11}\n",
                        named(m.states[static_cast<std::size_t>(i)]), error.max(i), error.quantile999(i), error.rms(i),
                        error.outside == 0 ? "-" : fmt::format("{:.1e}", error.max_outside(i)));
  text += fmt::format("  outside: over {} samples where in_domain() is false\n", grouped(error.outside));
  const std::string tanh = tanh_note(options);
  return tanh.empty() ? text : text + "  " + tanh + "\n";
}

std::string beyond_limits(const PreparedExport& prepared, const Eigen::VectorXd& limits) {
  const Model& m = prepared.model();
  const ExportOptions& options = prepared.options();
  const ExportError& error = prepared.error();
  for (int i = 0; i < m.nx(); ++i) {
    if (error.max(i) <= limits(i)) continue;
    std::string remedy = "allow more, or train again with weight_decay or over a smaller range of states";
    if (options.scalar != ScalarType::kDouble) {
      ExportOptions finer = options;
      const bool half = options.weights != WeightType::kFull;
      finer.weights = WeightType::kFull;
      if (!half) finer.scalar = options.scalar == ScalarType::kInt16 ? ScalarType::kFloat : ScalarType::kDouble;
      remedy = fmt::format("--{} has an error of {:.1e}; or {}",
                           half ? "weights float" : fmt::format("scalar {}", scalar_name(finer.scalar)),
                           prepared.with(finer).error().max(i), remedy);
    }
    return fmt::format(
        "{} has an error of {:.1e} in {} within its domain, but --max-error allows only {:.1e}; nothing is written. {}",
        named(m.states[static_cast<std::size_t>(i)]), error.max(i), numbers_name(options), limits(i), remedy);
  }
  return "";
}

}  // namespace nlo::codegen
