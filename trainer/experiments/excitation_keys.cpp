// SPDX-License-Identifier: MIT
#include "trainer/config/value.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

template <>
const std::vector<Key<ExcitationConfig>>& keys() {
  using X = ExcitationConfig;
  // Older experiments do not have them.
  const auto of_logs = [](Key<X> key) {
    key.only_when_given = true;
    return key;
  };
  static const std::vector<Key<X>> kKeys = {
      key("kinds", &X::kinds, names_of<InputSignal>(), "signals; one is drawn for each trajectory and input"),
      key("low", &X::low, any(), "lower end of what an input stays within, one number for each input"),
      key("high", &X::high, any(), "its upper end"),
      key("amplitude", &X::amplitude, at_least(0),
          "[least, most] of sine, square, multisine, chirp, about the middle of the range; up to half of it if not "
          "given"),
      key("shortest_s", &X::shortest_s, at_least(0),
          "least hold of steps and prbs, period of what swings and of the noise's cut-off [s]; 0: 10 sample periods"),
      key("longest_s", &X::longest_s, at_least(0), "the most of them, drawn log-uniformly [s]; 0: half the horizon"),
      of_logs(
          key("log", &X::log, any(),
              "kind \"log\": CSV file of recorded inputs, of which each run gets a stretch, looped where it is short")),
      of_logs(key("log_columns", &X::log_columns, any(), "its columns, one for each input")),
      of_logs(
          key("log_time", &X::log_time, any(), "its column of time [s]; rows are sample_period_s apart if not given")),
  };
  return kKeys;
}

template <>
std::string_view section_title<ExcitationConfig>() {
  return "[excitation]";
}

}  // namespace nlo::trainer
