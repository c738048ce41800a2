// SPDX-License-Identifier: MIT
// Rows about Proposition 2: the observer's error under noise, and the time in which it forgets a wrong initial value.
#include <fmt/format.h>

#include <limits>
#include <string>

#include "codegen/base/error.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/reachable_latent.h"
#include "trainer/prove/robustness.h"

namespace nlo::trainer {

std::string reason_against_plant(const codegen::Model& model, const CertifyOptions& options) {
  if (!moves_linearly(model) || codegen::inverse_map(model) == nullptr || model.nu() > 0)
    return fmt::format("the proof covers KKL observers without inputs, but this model has structure {}{}",
                       codegen::structure_name(model), model.nu() > 0 ? " and inputs" : "");
  if (options.experiment == nullptr || !options.experiment->plant)
    return "the proof needs the plant's equations: train with a [plant] section";
  if (const std::string why = reason_against_map(model); !why.empty()) return why;
  if (!PlantChannels(*options.experiment->plant, *make_plant(*options.experiment->plant)).plain())
    return "the proof needs all states of the plant as they are, but this observer estimates sines and cosines of "
           "angles, or omits states";
  for (const auto* channels : {&model.outputs, &model.states})
    for (const codegen::Channel& channel : *channels)
      if (channel.wrap != 0.0 || !channel.expression.empty())
        return fmt::format(
            "{} is an angle that wraps, or is computed from other channels; the proof does not cover this",
            channel.name);
  return {};
}

CertificateRows robustness_rows(const codegen::Model& model, const CertifyOptions& options) {
  constexpr const char* kWhat = "Proposition 2: |x_hat - x| under noise and disturbance";
  if (const std::string why = reason_against_plant(model, options); !why.empty())
    return {absent_row("robustness", kWhat, why)};
  RobustnessQuestion question{options.noise, options.disturbance};
  question.seed = options.seed;
  question.boxes = options.boxes;
  Robustness found;
  try {
    found = robustness(*make_plant(*options.experiment->plant), model, options.experiment->simulation, question);
  } catch (const codegen::Error& error) {
    return {absent_row("robustness", kWhat, error.what())};
  }
  const Evidence exactly = found.map.exact ? Evidence::kProven : Evidence::kSampled;
  CertificateRows rows;
  const auto add = [&](const std::string& id, const std::string& what, Evidence evidence, double bound, double seen,
                       const std::string& unit, const std::string& note) {
    CertificateRow row;
    row.id = "robustness." + id;
    row.what = what;
    row.unit = unit;
    row.evidence = evidence;
    row.bound = bound;
    row.found = seen;
    row.note = note;
    rows.push_back(std::move(row));
  };
  constexpr double kNone = CertificateRow::kNone;
  const std::string size = fmt::format("noise within {}, disturbance within {}", significant(options.noise),
                                       significant(options.disturbance));
  add("l_t", "L_T: |x1 - x2| <= L_T |T(x1) - T(x2)|", exactly, found.map.l_t, kNone, "", "");
  add("l_tx", "L_Tx: largest |dT/dx|", exactly, found.map.l_tx, kNone, "",
      std::isinf(found.map.l_tx) ? "D is slower than the plant contracts, and T is not differentiable" : "");
  add("approximation", "eps: largest |T*(T(x)) - x|", Evidence::kSampled, found.approximation, kNone, "",
      "at states that simulated runs visited");
  add("steady", fmt::format("|x_hat - x| once the start is forgotten, {}", size), Evidence::kSampled,
      found.bound.steady, found.steady_found, "",
      fmt::format(
          "computed from sampled constants; holds while z and T(x) stay in the domain; found in {} simulated runs",
          question.trajectories));
  add("paper", "|x_hat - x| once the start is forgotten, by the paper's bound (19) plus eps", Evidence::kSampled,
      found.paper.steady, found.steady_found, "", "(19) is a loose bound, see docs/appendix/reproduction.md");
  add("transient",
      fmt::format("last time at which |x_hat - x| is above {} without noise", significant(found.transient_level)),
      Evidence::kSampled, found.quiet.transient_s(found.start, found.transient_level),
      found.transient_s.value_or(std::numeric_limits<double>::infinity()), "s",
      "this level is a tenth of the initial error plus eps; found: rms over the runs, infinite if it is above the "
      "level at their end");
  return rows;
}

}  // namespace nlo::trainer
