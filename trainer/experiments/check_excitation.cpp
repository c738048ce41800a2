// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void refuse_excitation(const std::string& key, const std::string& what) {
  throw KeyError(key.empty() ? "excitation" : "excitation." + key,
                 fmt::format("[excitation]{}{}{}", key.empty() ? "" : " ", key, what));
}

void check_ranges(const ExcitationConfig& excitation, const std::vector<codegen::Channel>& inputs) {
  for (const auto& [key, given] : {std::pair{"low", &excitation.low}, std::pair{"high", &excitation.high}}) {
    if (given->empty())
      refuse_excitation("", fmt::format(" has no {}; give the range of the inputs: low = [...] and high = [...], one "
                                        "number for each input ({})",
                                        key, inputs.size()));
    if (given->size() != inputs.size())
      refuse_excitation(key, fmt::format(" has {} numbers, but the plant has {} inputs; give one for each",
                                         given->size(), inputs.size()));
  }
  const bool zero = std::ranges::find(excitation.kinds, InputSignal::kZero) != excitation.kinds.end();
  for (std::size_t j = 0; j < inputs.size(); ++j) {
    const double low = excitation.low[j], high = excitation.high[j];
    if (!(low <= high))
      refuse_excitation("high", fmt::format("[{0}] is {1}; it must not be below low[{0}], {2}", j, shortest_text(high),
                                            shortest_text(low)));
    if (zero && !(low <= 0.0 && 0.0 <= high))
      refuse_excitation("kinds",
                        fmt::format(" has \"zero\", but the range of {}, {} .. {}, has no 0; widen it, or leave "
                                    "\"zero\" out",
                                    inputs[j].name, shortest_text(low), shortest_text(high)));
  }
}

void check_amplitude(const ExcitationConfig& excitation, const std::vector<codegen::Channel>& inputs) {
  const auto& amplitude = excitation.amplitude;
  if (amplitude.empty()) return;
  if (amplitude.size() != 2)
    refuse_excitation("amplitude", fmt::format(" has {} numbers; give [smallest, largest]", amplitude.size()));
  if (!(amplitude[0] <= amplitude[1]))
    refuse_excitation("amplitude", fmt::format(" is [{}, {}]; the first must not be above the second",
                                               shortest_text(amplitude[0]), shortest_text(amplitude[1])));
  for (std::size_t j = 0; j < inputs.size(); ++j) {
    const double half = 0.5 * excitation.high[j] - 0.5 * excitation.low[j];
    constexpr double kRounding = 1e-12;  // relative to the half range, which is rounded: 0.1 to 0.7 gives 0.3
    if (amplitude[1] > half * (1.0 + kRounding))
      refuse_excitation("amplitude", fmt::format("[1] is {}; the range of {} allows at most {} about its middle",
                                                 shortest_text(amplitude[1]), inputs[j].name, shortest_text(half)));
  }
}

void check_times(const ExcitationConfig& excitation, const SimulationConfig& simulation) {
  const auto [shortest, longest] = hold_times(excitation, simulation);
  const char* key = excitation.shortest_s > 0.0 ? "shortest_s" : "longest_s";
  if (!(shortest >= simulation.sample_period_s))
    refuse_excitation(key, fmt::format(" is {}; inputs change at samples, so it must be at least sample_period_s, {}",
                                       shortest_text(shortest), shortest_text(simulation.sample_period_s)));
  if (!(shortest <= longest))
    refuse_excitation("longest_s", fmt::format(" is {}; it must not be below shortest_s, {}", shortest_text(longest),
                                               shortest_text(shortest)));
}

void check_log(const ExcitationConfig& excitation, const std::vector<codegen::Channel>& inputs) {
  const bool from_log = std::ranges::find(excitation.kinds, InputSignal::kLog) != excitation.kinds.end();
  const bool named = !excitation.log.empty() || !excitation.log_columns.empty() || !excitation.log_time.empty();
  if (!from_log && named)
    refuse_excitation("log", " is only used for the kind \"log\"; add \"log\" to kinds, or remove the keys of the log");
  if (!from_log) return;
  if (excitation.log.empty())
    refuse_excitation("kinds", " has \"log\", but no log is given; name the file: log = \"inputs.csv\"");
  if (excitation.log_columns.size() != inputs.size())
    refuse_excitation("log_columns", fmt::format(" has {} columns, but the plant has {} inputs; name one for each",
                                                 excitation.log_columns.size(), inputs.size()));
}

/// Refuses settings of training that runs with drawn inputs or parameters cannot satisfy.
void check_use(const Experiment& e) {
  const char* drawn = e.excitation                          ? "[excitation]"
                      : !e.simulation.process_noise.empty() ? "[simulation] process_noise"
                      : !e.plant->parameter_ranges.empty()  ? "[plant] parameters with a range"
                                                            : nullptr;
  if (drawn == nullptr) return;
  if (e.training.transient == Transient::kBackward)
    throw KeyError("training.transient", fmt::format("[training] transient = \"backward\" needs a plant without inputs "
                                                     "and noise, to simulate its past, but there is {}; use \"drop\"",
                                                     drawn));
}

}  // namespace

void check_excitation(const Experiment& e) {
  check_use(e);
  const auto plant = make_plant(*e.plant);
  if (const std::size_t given = e.simulation.process_noise.size(); given > 0 && given != plant->states().size())
    throw KeyError("simulation.process_noise",
                   fmt::format("[simulation] process_noise has {} numbers; the plant has {} states: give one for each, "
                               "and 0 for a state without noise",
                               given, plant->states().size()));
  if (e.simulation.process_noise.empty() && e.simulation.process_noise_share != 1.0)
    throw KeyError("simulation.process_noise_share",
                   "[simulation] process_noise_share has no effect without process_noise; give process_noise a number "
                   "for each state, or remove process_noise_share");
  if (!e.excitation) return;
  const ExcitationConfig& excitation = *e.excitation;
  if (plant->nu() == 0)
    refuse_excitation("",
                      fmt::format(" needs inputs, but the plant {} has none; name them in [plant] inputs, or remove "
                                  "it",
                                  plant->name()));
  if (excitation.kinds.empty()) refuse_excitation("kinds", " is empty; name at least one, such as \"steps\"");
  check_ranges(excitation, plant->inputs());
  check_amplitude(excitation, plant->inputs());
  check_times(excitation, e.simulation);
  check_log(excitation, plant->inputs());
}

}  // namespace nlo::trainer
