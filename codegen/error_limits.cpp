// SPDX-License-Identifier: MIT
#include "codegen/error_limits.h"

#include <cmath>
#include <limits>
#include <utility>

#include "codegen/checks.h"
#include "codegen/key_values.h"
#include "codegen/number_formats.h"
#include "codegen/targets/generated_text.h"

namespace nlo::codegen {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

double limit_of(const std::string& text) {
  const double limit = decimal(text);
  if (!(limit > 0.0) || !std::isfinite(limit))
    fail("--max-error: \"{}\" is no limit; give a positive number, such as 0.01", text);
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

std::string error_table(const Model& m, const ExportOptions& options, const ExportError& error) {
  std::string text = fmt::format("error of {} against the model's equations, over {} of {} replay samples\n",
                                 numbers_name(options), error.samples, options.samples);
  for (int i = 0; i < m.nx(); ++i)
    text += fmt::format("  {:<24}  max {:.1e}  rms {:.1e}\n", named(m.states[static_cast<std::size_t>(i)]),
                        error.max(i), error.rms(i));
  const std::string tanh = tanh_note(options);
  return tanh.empty() ? text : text + "  " + tanh + "\n";
}

std::string beyond_limits(const Model& m, const ExportOptions& options, const ExportError& error,
                          const Eigen::VectorXd& limits) {
  for (int i = 0; i < m.nx(); ++i) {
    if (error.max(i) <= limits(i)) continue;
    std::string mend = "allow more, or train again with weight_decay or over a smaller range of states";
    if (options.scalar != ScalarType::kDouble) {
      ExportOptions finer = options;
      const bool half = options.weights != WeightType::kFull;
      finer.weights = WeightType::kFull;
      if (!half) finer.scalar = options.scalar == ScalarType::kInt16 ? ScalarType::kFloat : ScalarType::kDouble;
      mend = fmt::format("--{} is off by {:.1e}; or {}",
                         half ? "weights float" : fmt::format("scalar {}", scalar_name(finer.scalar)),
                         export_error(m, finer).max(i), mend);
    }
    return fmt::format("{} is off by {:.1e} in {}, and --max-error allows {:.1e}; nothing is written. {}",
                       named(m.states[static_cast<std::size_t>(i)]), error.max(i), numbers_name(options), limits(i),
                       mend);
  }
  return "";
}

}  // namespace nlo::codegen
