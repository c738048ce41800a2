// SPDX-License-Identifier: MIT
#include "trainer/config/value.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

template <>
const std::vector<Key<FeedbackConfig>>& keys() {
  using F = FeedbackConfig;
  static const std::vector<Key<F>> kKeys = {
      key("law", &F::law, any(),
          "u = k(x_hat, r), an expression for each input over estimated states, parameters and references; the "
          "reference r_INPUT is the value that [excitation] draws for INPUT, or 0"),
      key("actuator_low", &F::actuator_low, any(), "lower limit to which each input is clipped"),
      key("actuator_high", &F::actuator_high, any(), "upper limit to which each input is clipped"),
      key("share", &F::share, between(0, 1), "share of the runs in closed loop; the other runs use the drawn u"),
      key("error", &F::error, at_least(0),
          "standard deviation of x_hat - x in round 0, one for each state of the plant; the error is drawn once for "
          "each run; none if not given"),
      key("rounds", &F::rounds, between(0, 20),
          "number of rounds after round 0; each adds runs with the last round's observer in the loop and trains on all "
          "runs"),
      key("cost", &F::cost, any(),
          "cost of a sample, an expression over states, inputs and parameters; nlo evaluate shows its mean, and the "
          "mean in the loop of the true state"),
  };
  return kKeys;
}

template <>
std::string_view section_title<FeedbackConfig>() {
  return "[feedback]";
}

}  // namespace nlo::trainer
