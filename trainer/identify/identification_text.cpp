// SPDX-License-Identifier: MIT
#include "trainer/identify/identification_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/evaluation/evaluation_text.h"

namespace nlo::trainer {
namespace {

std::string remark(const ParameterEstimate& p) {
  if (p.fixed) return "fixed";
  if (p.at_bound) return "at its bound";
  if (p.unidentified) return "not identified";
  if (!(2.0 * p.clustered_error < std::abs(p.value))) return "not told from 0";
  return "";
}

std::string notes_of(const IdentificationResult& result) {
  std::string notes, unidentified;
  for (const ParameterEstimate& p : result.parameters)
    if (p.unidentified && !p.at_bound) unidentified += (unidentified.empty() ? "" : ", ") + p.name;
  if (!unidentified.empty())
    notes += fmt::format(
        "- {}: the logs do not tell {} (the condition number is {}): fix one of them by [identify] "
        "fixed, or lump them\n",
        unidentified, unidentified.find(',') == std::string::npos ? "it" : "them apart",
        significant(result.condition, 2));
  constexpr double kFar = 10.0;
  if (result.residual_deviation > kFar)
    notes += fmt::format(
        "- residuals are {} times [identify] noise: the search may be stuck, or the model is another plant's. Try "
        "shorter "
        "segments (segment_s) and other starting values\n",
        significant(result.residual_deviation, 2));
  constexpr double kCorrelated = 0.5;
  for (const FittedError& error : result.training)
    if (error.correlation > kCorrelated)
      notes += fmt::format(
          "- residuals of {} are correlated from sample to sample ({}): the model is not quite the rig's. "
          "Trust the standard errors by segments, which allow for that\n",
          error.name, significant(error.correlation, 2));
  return notes.empty() ? "" : "\n" + notes;
}

}  // namespace

std::string to_text(const IdentificationResult& result) {
  std::string text =
      fmt::format("{} after {} iterations: {} residuals in {} segments, {} parameters found, deviation {}\n\n",
                  result.outcome, result.iterations, result.residuals, result.segments,
                  std::count_if(result.parameters.begin(), result.parameters.end(),
                                [](const ParameterEstimate& p) { return !p.fixed; }),
                  significant(result.residual_deviation));
  Table parameters{{"parameter", "start", "estimate", "standard error", "by segments", "remark"}};
  for (const ParameterEstimate& p : result.parameters) {
    const bool none = p.fixed || p.unidentified;
    parameters.add_row({p.name, significant(p.start, 4), significant(p.value, 5),
                        none ? "-" : significant(p.standard_error, 2), none ? "-" : significant(p.clustered_error, 2),
                        remark(p)});
  }
  text += parameters.to_text(2) + "\n";
  Table errors{{"RMSE over segments", "training", "test"}};
  for (std::size_t i = 0; i < result.training.size(); ++i)
    errors.add_row({with_unit(result.training[i].name, result.training[i].unit), significant(result.training[i].rmse),
                    result.test.empty() ? "-" : significant(result.test[i].rmse)});
  return text + errors.to_text(2) + notes_of(result);
}

std::string to_text(const FilterStudy& study) {
  std::string text = fmt::format("Estimates on {}; filters tuned on {}\n", study.judged_on, study.tuned_on);
  text += "\n" + log_table(study.entries, true).to_text(2) + "\n";
  for (const LogEntry& entry : study.entries)
    if (!entry.setup.empty()) text += fmt::format("{}: {}\n", entry.estimator, entry.setup);
  return text + "operations and functions: per step, counted (see nlo identify --help)\n";
}

}  // namespace nlo::trainer
