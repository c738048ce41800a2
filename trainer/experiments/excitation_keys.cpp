// SPDX-License-Identifier: MIT
#include "trainer/config/value.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

template <>
const std::vector<Key<ExcitationConfig>>& keys() {
  using X = ExcitationConfig;
  // These keys are omitted from records of experiments that do not use them, so old records stay the same.
  const auto of_logs = [](Key<X> key) {
    key.only_when_given = true;
    return key;
  };
  static const std::vector<Key<X>> kKeys = {
      key("kinds", &X::kinds, names_of<InputSignal>(), "signals; one is drawn for each trajectory and input"),
      key("low", &X::low, any(), "lower limit of each input"),
      key("high", &X::high, any(), "upper limit of each input"),
      key("amplitude", &X::amplitude, at_least(0),
          "[smallest, largest] amplitude of sine, square, multisine and chirp about the middle of the range; if not "
          "given, up to half of the range"),
      key("shortest_s", &X::shortest_s, at_least(0),
          "shortest hold of steps and prbs, shortest period of oscillations and of the noise's cut-off [s]; 0: 10 "
          "sample periods"),
      key("longest_s", &X::longest_s, at_least(0),
          "the longest of these times [s], which are drawn log-uniformly; 0: half the horizon"),
      of_logs(
          key("log", &X::log, any(),
              "kind \"log\": CSV file of recorded inputs; each run uses a part of it, and a run longer than the log "
              "repeats it")),
      of_logs(key("log_columns", &X::log_columns, any(), "columns of that file, one for each input")),
      of_logs(key("log_time", &X::log_time, any(),
                  "column of time [s] in that file; if not given, rows are sample_period_s apart")),
  };
  return kKeys;
}

template <>
std::string_view section_title<ExcitationConfig>() {
  return "[excitation]";
}

}  // namespace nlo::trainer
