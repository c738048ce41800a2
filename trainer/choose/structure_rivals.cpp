// SPDX-License-Identifier: MIT
#include "trainer/choose/structure_rivals.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
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

/// A structure with known equations starts as a tuned filter, so it has little to learn and needs small steps. Logs are
/// few, so its corrections are kept small there by weight decay.
struct Effort {
  int units, steps;
  double learning_rate, weight_decay, ridge;
};

Effort effort_of(const TrainableStructure& structure, const Experiment& base) {
  const double decay = base.training.weight_decay, ridge = base.inverse_map.ridge;
  if (!structure.has_known_equations()) return {32, 6000, 1e-2, decay, ridge};
  return base.log ? Effort{16, 1500, 2e-3, 0.1, 1e-2} : Effort{16, 1500, 2e-3, decay, ridge};
}

}  // namespace

Experiment checked(const Experiment& derived, const Experiment& base) {
  Experiment experiment = parse_experiment(format_experiment(derived), "what was derived");
  experiment.threads = base.threads;
  return experiment;
}

Experiment with_structure(const DraftExperiment& draft, const Experiment& base, const TrainableStructure& structure,
                          const DataScales& scales, bool has_units) {
  const auto set = [&draft](const char* key, auto& value, auto derived) {
    if (!draft.given.has(key)) value = std::move(derived);
  };
  constexpr double kLongest = 500.0;  // longest segment in samples: the time for gradients is proportional to it
  const double period_s = scales.sample_period_s, samples = scales.run_length_s / period_s;
  Experiment e = base;
  if (!structure.adopt(e, period_s))
    throw codegen::Error(fmt::format("structure \"{}\" does not fit the experiment", structure.name()));
  if (base.observer.structure == structure.name()) e.observer = base.observer;
  const InverseMapConfig usual_map = std::exchange(e.inverse_map, base.inverse_map);
  const TrainingConfig usual_training = std::exchange(e.training, base.training);
  const Effort effort = effort_of(structure, base);
  UnitSettings& units = e.observer.own.set<UnitSettings>();
  set("observer.units", units.units, has_units ? effort.units : 0);
  set("loss.scale", e.loss.scale, ErrorScale::kNormalised);
  TrainingConfig& t = e.training;
  // Logs are few, so a filter is also tuned on starts within them.
  const bool starts_within_logs = base.log && structure.has_known_equations();
  const double longest = starts_within_logs ? std::clamp(samples / 4.0, 300.0, kLongest) : kLongest;
  if (samples > 2.0 * longest && t.transient == Transient::kKeep && (units.units > 0 || starts_within_logs)) {
    set("training.segment_s", t.segment_s, rounded(longest * period_s));
    set("training.first_share", t.first_share, 0.5);
  }
  if (units.units == 0) {
    // A filter: T* passes on its state, and there is nothing to train.
    set("inverse_map.hidden", e.inverse_map.hidden, std::vector<int>{});
    set("inverse_map.linear_path", e.inverse_map.linear_path, true);
    set("inverse_map.readout", e.inverse_map.readout, ReadoutChoice::kNetwork);
    set("training.steps", t.steps, 0);
    return checked(e, base);
  }
  set("observer.rates", units.rates,
      std::vector<double>{rounded(std::min(scales.slowest, 0.1 / period_s)), rounded(0.5 / period_s)});
  set("inverse_map.hidden", e.inverse_map.hidden, usual_map.hidden);
  set("inverse_map.linear_path", e.inverse_map.linear_path, usual_map.linear_path);
  set("training.steps", t.steps, effort.steps);
  set("training.trajectories_per_step", t.trajectories_per_step, starts_within_logs ? 16 : 32);
  set("training.samples_per_step", t.samples_per_step,
      static_cast<int>(std::min(samples, longest) * t.trajectories_per_step));
  set("inverse_map.ridge", e.inverse_map.ridge, effort.ridge);
  set("training.learning_rate", t.learning_rate, effort.learning_rate);
  set("training.weight_decay", t.weight_decay, effort.weight_decay);
  set("training.schedule", t.schedule, std::string("cosine"));
  set("training.gradient_clip", t.gradient_clip, usual_training.gradient_clip);
  set("training.ema", t.ema, 0.998);
  set("training.validate_every", t.validate_every, std::clamp(t.steps / 12, 1, 500));
  return checked(e, base);
}

bool is_filter(const Experiment& experiment) {
  const ObserverConfig& o = experiment.observer;
  return structure_of(o).has_known_equations() && o.own.get<UnitSettings>().units == 0;
}

std::string misleading_validation(const TrainableStructure& structure, const Experiment& base) {
  if (!structure.has_known_equations()) return {};
  if (const std::string count = base.plant ? counted_state(*base.plant) : ""; !count.empty())
    return fmt::format(
        "{0} may count without end, and a flight beyond its range in training would be clamped. If {0} is an angle, "
        "give its full turn in [plant] state_wraps and output_wraps, and \"sincos\" in state_encodings and "
        "output_encodings",
        count);
  if (simulates_an_exact_plant(base))
    return "it would trust the equations completely. Give each parameter that is not known exactly a range, "
           "damping = [0.3, 0.5], or give [simulation] process_noise";
  return {};
}

std::vector<Rival> structure_rivals(const DraftExperiment& draft, const Experiment& base, const DataScales& scales) {
  std::vector<Rival> rivals;
  if (wants_a_linear_latent(draft)) return rivals;
  for (const TrainableStructure* structure : structure_table()) {
    if (structure->name() == base.observer.structure) continue;
    if (structure->learns_to_average_noise() && simulates_without_noise(base)) continue;
    try {
      const std::string misleads = misleading_validation(*structure, base);
      if (structure->has_known_equations() && misleads.empty())
        rivals.push_back({with_structure(draft, base, *structure, scales, false), misleads});
      rivals.push_back({with_structure(draft, base, *structure, scales), misleads});
    } catch (const codegen::Error&) {
      continue;  // the structure does not fit
    }
  }
  return rivals;
}

}  // namespace nlo::trainer
