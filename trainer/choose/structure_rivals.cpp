// SPDX-License-Identifier: MIT
#include "trainer/choose/structure_rivals.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/draws.h"
#include "trainer/plants/run_range.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/trainable_structure.h"
#include "trainer/structures/unit_settings.h"

namespace nlo::trainer {
namespace {

bool wants_a_linear_latent(const DraftExperiment& draft) {
  return std::ranges::any_of(std::initializer_list<const char*>{"structure", "learn_eigenvalues", "output_injection",
                                                                "hold", "start", "clocks_s", "features", "saturation"},
                             [&](const char* key) { return draft.given.has(std::string("observer.") + key); });
}

bool simulates_without_noise(const Experiment& e) {
  return !e.log && std::ranges::all_of(e.training.all_noise().parts, &NoiseConfig::none);
}

bool simulates_an_exact_plant(const Experiment& e) {
  return !e.log && e.plant && e.plant->parameter_ranges.empty() && e.simulation.process_noise.empty();
}

/// Returns the reason why a short training of a structure with known equations would mislead; empty if it would not.
std::string misleads(const Experiment& base) {
  if (simulates_an_exact_plant(base))
    return "it would trust the equations completely. Give each parameter that is not known exactly a range, "
           "damping = [0.3, 0.5], or give [simulation] process_noise";
  if (const std::string count = base.plant ? counted_state(*base.plant) : ""; !count.empty())
    return fmt::format(
        "{0} may count without end, and a flight beyond its range in training would be clamped. If {0} is "
        "an angle, give its sine and cosine: [plant] state_encodings and output_encodings",
        count);
  return {};
}

/// Equations start as a tuned filter, so there is little to learn, in small steps.
struct Effort {
  int units, steps;
  double learning_rate;
};

Effort effort_of(const TrainableStructure& structure) {
  return structure.has_known_equations() ? Effort{16, 1500, 2e-3} : Effort{32, 6000, 1e-2};
}

/// Returns `base` with this structure, empty if it does not fit.
std::optional<Experiment> rival(const DraftExperiment& draft, const Experiment& base,
                                const TrainableStructure& structure, double sample_period_s, double length_s,
                                double slowest) {
  const auto set = [&draft](const char* key, auto& value, auto derived) {
    if (!draft.given.has(key)) value = std::move(derived);
  };
  constexpr double kLongest = 500.0;  // longest segment in samples: the time for gradients is proportional to it
  const double samples = length_s / sample_period_s;
  Experiment e = base;
  if (!structure.adopt(e, sample_period_s)) return std::nullopt;
  const InverseMapConfig usual_map = std::exchange(e.inverse_map, base.inverse_map);
  const TrainingConfig usual_training = std::exchange(e.training, base.training);
  const Effort effort = effort_of(structure);
  UnitSettings& units = e.observer.own.set<UnitSettings>();
  units.units = effort.units;
  units.rates = {rounded(std::min(slowest, 0.1 / sample_period_s)), rounded(0.5 / sample_period_s)};
  set("inverse_map.hidden", e.inverse_map.hidden, usual_map.hidden);
  set("inverse_map.linear_path", e.inverse_map.linear_path, usual_map.linear_path);
  set("loss.scale", e.loss.scale, ErrorScale::kNormalised);
  TrainingConfig& t = e.training;
  set("training.steps", t.steps, effort.steps);
  set("training.trajectories_per_step", t.trajectories_per_step, 32);
  set("training.samples_per_step", t.samples_per_step,
      static_cast<int>(std::min(samples, kLongest) * t.trajectories_per_step));
  if (samples > 2.0 * kLongest && t.transient == Transient::kKeep) {
    set("training.segment_s", t.segment_s, kLongest * sample_period_s);
    set("training.first_share", t.first_share, 0.5);
  }
  set("training.learning_rate", t.learning_rate, effort.learning_rate);
  set("training.schedule", t.schedule, std::string("cosine"));
  set("training.gradient_clip", t.gradient_clip, usual_training.gradient_clip);
  set("training.ema", t.ema, 0.998);
  set("training.validate_every", t.validate_every, std::clamp(t.steps / 12, 1, 500));
  try {
    Experiment checked = parse_experiment(format_experiment(e), "a rival of the derived observer");
    checked.threads = base.threads;
    return checked;
  } catch (const codegen::Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<Rival> structure_rivals(const DraftExperiment& draft, const Experiment& base, double sample_period_s,
                                    double length_s, double slowest) {
  std::vector<Rival> rivals;
  if (wants_a_linear_latent(draft)) return rivals;
  for (const TrainableStructure* structure : structure_table()) {
    if (structure->name() == base.observer.structure) continue;
    if (structure->learns_to_average_noise() && simulates_without_noise(base)) continue;
    std::optional<Experiment> e = rival(draft, base, *structure, sample_period_s, length_s, slowest);
    if (!e) continue;
    rivals.push_back({*std::move(e), structure->has_known_equations() ? misleads(base) : ""});
  }
  return rivals;
}

}  // namespace nlo::trainer
