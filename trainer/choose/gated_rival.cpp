// SPDX-License-Identifier: MIT
#include "trainer/choose/gated_rival.h"

#include <algorithm>
#include <string>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/draws.h"
#include "trainer/structures/failing_sensors.h"
#include "trainer/structures/unit_settings.h"

namespace nlo::trainer {

std::optional<Experiment> gated_rival(const DraftExperiment& draft, const Experiment& base, double length_s) {
  const NoiseMixture noise = base.training.all_noise();
  const bool quiet = std::all_of(noise.parts.begin(), noise.parts.end(), [](const NoiseConfig& n) { return n.none(); });
  if (base.log || quiet) return std::nullopt;
  for (const char* key :
       {"structure", "learn_eigenvalues", "output_injection", "hold", "start", "clocks_s", "features", "saturation"})
    if (draft.given.has(std::string("observer.") + key)) return std::nullopt;

  const auto set = [&](const char* key, auto& value, auto derived) {
    if (!draft.given.has(key)) value = std::move(derived);
  };
  constexpr double kLongest = 500.0;  // samples of a segment: gradients through time are paid by the sample
  const double period_s = base.simulation.sample_period_s, samples = length_s / period_s;
  Experiment e = base;
  e.observer = plain_observer_of("gated", base.observer);
  e.observer.own.set<UnitSettings>().rates = {rounded(std::min(3.0 / length_s, 0.1 / period_s)),
                                              rounded(0.5 / period_s)};
  set("inverse_map.hidden", e.inverse_map.hidden, std::vector<int>{32});
  set("inverse_map.linear_path", e.inverse_map.linear_path, false);
  set("loss.scale", e.loss.scale, ErrorScale::kNormalised);
  TrainingConfig& t = e.training;
  set("training.steps", t.steps, 6000);
  set("training.trajectories_per_step", t.trajectories_per_step, 32);
  set("training.samples_per_step", t.samples_per_step,
      static_cast<int>(std::min(samples, kLongest) * t.trajectories_per_step));
  if (samples > 2.0 * kLongest && t.transient == Transient::kKeep) {
    set("training.segment_s", t.segment_s, kLongest * period_s);
    set("training.first_share", t.first_share, 0.5);
  }
  set("training.learning_rate", t.learning_rate, 1e-2);
  set("training.schedule", t.schedule, std::string("cosine"));
  set("training.gradient_clip", t.gradient_clip, 1.0);
  set("training.ema", t.ema, 0.998);
  set("training.validate_every", t.validate_every, 500);
  try {
    Experiment checked = parse_experiment(format_experiment(e), "a gated rival");
    checked.threads = base.threads;
    return checked;
  } catch (const codegen::Error&) {
    return std::nullopt;
  }
}

}  // namespace nlo::trainer
