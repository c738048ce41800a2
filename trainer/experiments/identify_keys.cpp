// SPDX-License-Identifier: MIT
#include "trainer/experiments/identify_keys.h"

#include "trainer/config/value.h"

namespace nlo::trainer {
namespace {

/// The key noise: { NAME = number, ... }.
Key<IdentifyConfig> noise_key() {
  return {"noise", "{ NAME = number > 0, ... }",
          "the outputs and logged states that are fitted, each with the standard deviation of its error",
          [](IdentifyConfig& identify, const Toml& value, const std::string& where) {
            std::vector<std::pair<std::string, std::array<double, 2>>> ranges;
            read_parameters(value, where, identify.noise, ranges);
            for (const auto& [name, member] : members_in_order(value)) {
              double deviation = 0.0;
              read_value(*member, where + "." + name, positive(), deviation);
            }
          },
          [](const IdentifyConfig& identify) { return show_parameters(identify.noise, {}); }};
}

}  // namespace

template <>
const std::vector<Key<Identification>>& keys() {
  using I = Identification;
  static const std::vector<Key<I>> kKeys = {
      key("name", &I::name, identifiers(), "name of the output folder"),
      key("threads", &I::threads, between(0, 1024),
          "number of threads; 0: all cores; the result does not depend on it"),
  };
  return kKeys;
}

template <>
const std::vector<Key<IdentifyConfig>>& keys() {
  using I = IdentifyConfig;
  static const std::vector<Key<I>> kKeys = {
      key("segment_s", &I::segment_s, positive(),
          "length of the simulated segments [s]; each has its own initial state"),
      key("most_samples", &I::most_samples, between(10, 1e7),
          "largest number of samples of the training logs; if there are more, whole segments are left out"),
      noise_key(),
      key("initial_state", &I::initial_state, any(),
          "initial state of filters and segments, one number for each state; used for states that no output measures"),
      key("initial_deviation", &I::initial_deviation, at_least(0),
          "standard deviation of the initial state, one number for each state; 0: exactly known. An angle that no "
          "output measures and whose deviation is turn / sqrt(12) or more may start anywhere: filters then start "
          "all around the turn"),
      key("process_noise", &I::process_noise, at_least(0),
          "process noise of the filters per sqrt(s), from which their tuning starts; one number for each state"),
      key("fixed", &I::fixed, identifiers(), "parameters that keep their values"),
      key("positive", &I::positive, identifiers(),
          "parameters that stay positive; a range [low, high] in [plant] also bounds a parameter"),
      key("input_hold", &I::input_hold, one_of({"zero_order", "first_order"}),
          "zero_order: the u of a row has acted since the last row; first_order: it was measured with the row"),
      key("longest_step_s", &I::longest_step_s, at_least(0),
          "longest step of the simulation (RK4) [s]; 0: the sample period"),
      key("iterations", &I::iterations, between(1, 10000),
          "largest number of iterations of Levenberg and Marquardt's method"),
      key("from_s", &I::from_s, at_least(0), "times at which the filters start in each log, for tuning and tests [s]"),
  };
  return kKeys;
}

// clang-format off
template <> std::string_view section_title<Identification>() { return "the identification"; }
template <> std::string_view section_title<IdentifyConfig>() { return "[identify]"; }
// clang-format on

}  // namespace nlo::trainer
