// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/transient.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {
namespace {

/// Returns the number of measured quantities. An angle as sine and cosine counts once.
std::size_t sensors(const Experiment& e) {
  return e.plant ? make_plant(*e.plant)->outputs().size() : resolve_columns(*e.log).outputs.size();
}

void check_input_noise(const Experiment& e) {
  const NoiseConfig& noise = e.training.input_noise;
  if (noise.none()) return;
  const auto refuse = [](const std::string& why) {
    throw KeyError("training.input_noise", "[training] input_noise " + why);
  };
  const int inputs = observer_channels(e).read_inputs;
  if (inputs == 0)
    refuse(
        "is the noise of inputs that the observer reads, but it reads none; give [excitation] or a column with role = "
        "\"input\", "
        "or remove it");
  for (const SensorNoise& own : noise.sensors)
    if (own.jitter > 0.0)
      refuse("has jitter, which applies to the times of measurements; write it in [training] noise");
  try {
    check_noise(noise, static_cast<std::size_t>(inputs));
  } catch (const codegen::Error& error) {
    refuse(fmt::format("is not a noise for {} inputs: {}", inputs, error.what()));
  }
}

void check_steps(const Experiment& e) {
  if (e.training.steps == 0 && !e.inverse_map.linear_path)
    throw KeyError("training.steps",
                   "[training] steps = 0 leaves the network untrained, and without a linear path it is random; set "
                   "[inverse_map] linear_path = true, or a number of steps");
}

}  // namespace

void check_training(const Experiment& e) {
  const TrainingConfig& t = e.training;
  if (t.gradient != LatentGradient::kAutomatic)
    check_zero_start(e.observer, "a roll-out by gradient = \"backprop\" or \"adjoint\"");
  if (t.early_share > 0.0 && t.early_s == 0.0)
    throw KeyError("training.early_share", "[training] early_share needs the time early_s; set both or neither");
  if (t.segment_s == 0.0 && (t.first_segment_s > 0.0 || t.first_share > 0.0))
    throw KeyError(t.first_segment_s > 0.0 ? "training.first_segment_s" : "training.first_share",
                   "[training] first_segment_s and first_share apply to random segments, but here each trajectory is "
                   "one segment; set segment_s, or remove them");
  if (t.first_segment_s > t.segment_s)
    throw KeyError(
        "training.first_segment_s",
        fmt::format("[training] first_segment_s is {}, but segments grow from it to segment_s, {}: it must be smaller",
                    shortest_text(t.first_segment_s), shortest_text(t.segment_s)));
  if (!t.noise_mixture.empty() && !t.noise.none())
    throw KeyError(
        "training.noise_mixture",
        "[training] noise_mixture replaces noise, but both are given; add that noise to the mixture and remove noise");
  if (t.noise_level_max > 0.0 && t.noise_mixture.empty() && t.noise.none() && t.input_noise.none())
    throw KeyError("training.noise_level_max",
                   "[training] noise_level_max scales the noise, but there is none; set noise = \"gaussian:1\", or "
                   "remove noise_level_max");
  try {
    for (const NoiseConfig& noise : t.all_noise().parts) check_noise(noise, sensors(e));
  } catch (const codegen::Error& error) {
    throw KeyError(t.noise_mixture.empty() ? "training.noise" : "training.noise_mixture",
                   fmt::format("[training] {}", error.what()));
  }
  if (e.inverse_map.error && e.inverse_map.hidden.empty())
    throw KeyError("inverse_map.error",
                   "[inverse_map] error reads the last hidden layer of T*, but hidden = [] means that there is none; "
                   "add a layer, or remove error");
  if (e.inverse_map.fallback && (!e.log || e.validation.folds == 0 || !is_chosen(e.inverse_map.readout)))
    throw KeyError("inverse_map.fallback",
                   "[inverse_map] fallback is selected on left-out logs, but there are none; give [log] with folds and "
                   "without readout = \"network\", or remove fallback");
  check_steps(e);
  check_input_noise(e);
}

void check_transient(const Experiment& e) {
  const TrainingConfig& t = e.training;
  if (t.transient == Transient::kKeep) return;
  const std::string_view how = to_name(t.transient);
  if (t.transient == Transient::kBackward && e.log)
    throw KeyError("training.transient",
                   "[training] transient = \"backward\" simulates the past of a plant, but this experiment has logs; "
                   "use \"drop\"");
  if (t.segment_s > 0.0)
    throw KeyError("training.segment_s",
                   fmt::format("[training] segment_s starts the filter again inside of a trajectory, where transient = "
                               "\"{}\" does not exclude its transient; set segment_s = 0, or transient = \"keep\"",
                               how));
  if (t.early_share > 0.0)
    throw KeyError("training.early_share", fmt::format("[training] early_share draws samples from the transient, which "
                                                       "transient = \"{}\" leaves out; remove one of them",
                                                       how));
  const double t_c = transient_time_s(e.observer, t.transient_factor);
  if (!std::isfinite(t_c))
    throw KeyError("training.transient", fmt::format("[training] transient = \"{}\" needs eigenvalues of a filter, but "
                                                     "this observer has none; set transient = \"keep\"",
                                                     how));
  if (!e.plant) return;
  const SimulationConfig& s = e.simulation;
  const std::string length = fmt::format("the transient lasts {:.4g} s (transient_factor / min |Re lambda|)", t_c);
  if (t.transient == Transient::kDrop && t_c >= s.horizon_s)
    throw KeyError("training.transient", fmt::format("[training] transient = \"drop\" leaves no sample of the horizon "
                                                     "of {} s: {}; use faster eigenvalues or a longer horizon",
                                                     shortest_text(s.horizon_s), length));
  const double samples = (t_c + s.horizon_s) / s.sample_period_s;
  if (t.transient == Transient::kBackward &&
      (samples > kMostSamples ||
       samples * s.trajectories * static_cast<double>(make_plant(*e.plant)->nx()) > kMostNumbers))
    throw KeyError("training.transient",
                   fmt::format("[training] transient = \"backward\" makes trajectories of {:.3g} samples, "
                               "which do not fit into memory: {}; use faster eigenvalues",
                               samples, length));
}

}  // namespace nlo::trainer
