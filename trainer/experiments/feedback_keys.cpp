// SPDX-License-Identifier: MIT
#include "trainer/config/value.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

template <>
const std::vector<Key<FeedbackConfig>>& keys() {
  using F = FeedbackConfig;
  static const std::vector<Key<F>> kKeys = {
      key("law", &F::law, any(),
          "u = k(x_hat, r), an expression for each input over estimated states, parameters and references: r_INPUT is "
          "what "
          "[excitation] draws for INPUT, 0 without it"),
      key("actuator_low", &F::actuator_low, any(), "lower end of what an input is clipped to, one for each input"),
      key("actuator_high", &F::actuator_high, any(), "its upper end"),
      key("share", &F::share, between(0, 1), "of the runs that are in the loop; the others have u as drawn"),
      key("error", &F::error, at_least(0),
          "deviation of what x_hat is off the true state by in round 0, one for each state of the plant, drawn for "
          "each run; none "
          "if not given"),
      key("rounds", &F::rounds, between(0, 20),
          "after round 0, each adds runs with the last round's observer in the loop and trains on all"),
      key("cost", &F::cost, any(),
          "of a sample, an expression over states, inputs and parameters; nlo evaluate shows its mean beside that of "
          "the true state's loop"),
  };
  return kKeys;
}

template <>
std::string_view section_title<FeedbackConfig>() {
  return "[feedback]";
}

}  // namespace nlo::trainer
