// SPDX-License-Identifier: MIT
#include "trainer/experiments/identify_keys.h"

#include "trainer/config/value.h"

namespace nlo::trainer {
namespace {

/// { NAME = number, ... }.
Key<IdentifyConfig> noise_key() {
  return {"noise", "{ NAME = number > 0, ... }",
          "what is fitted, outputs and logged states, each with the standard deviation of its error",
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
      key("name", &I::name, identifiers(), "names the output folder"),
      key("threads", &I::threads, between(0, 1024), "0: all cores; the result does not depend on it"),
  };
  return kKeys;
}

template <>
const std::vector<Key<IdentifyConfig>>& keys() {
  using I = IdentifyConfig;
  static const std::vector<Key<I>> kKeys = {
      key("segment_s", &I::segment_s, positive(),
          "length of the segments that are simulated, each from a state of its own [s]"),
      key("most_samples", &I::most_samples, between(10, 1e7),
          "of the training logs; more are thinned by whole segments"),
      noise_key(),
      key("initial_state", &I::initial_state, any(),
          "of the filters and of segments, where no output says it; one number for each state"),
      key("initial_deviation", &I::initial_deviation, at_least(0),
          "how far from there, one number for each state; 0: exactly there; from turn / sqrt(12) on, an angle that no "
          "output measures may be anywhere, and filters start all around"),
      key("process_noise", &I::process_noise, at_least(0),
          "of the filters' states per sqrt(s), where their tuning starts; one number for each state"),
      key("fixed", &I::fixed, identifiers(), "parameters that are not looked for"),
      key("positive", &I::positive, identifiers(),
          "parameters that stay positive; a range [low, high] bounds one, too"),
      key("input_hold", &I::input_hold, one_of({"zero_order", "first_order"}),
          "the u of a row has acted since the row before, or was measured with it"),
      key("longest_step_s", &I::longest_step_s, at_least(0), "of the simulation (RK4) [s]; 0: the sample period"),
      key("iterations", &I::iterations, between(1, 10000), "of Levenberg and Marquardt's method, at most"),
      key("from_s", &I::from_s, at_least(0), "where the filters start in each log they are tuned on and judged by [s]"),
  };
  return kKeys;
}

// clang-format off
template <> std::string_view section_title<Identification>() { return "the identification"; }
template <> std::string_view section_title<IdentifyConfig>() { return "[identify]"; }
// clang-format on

}  // namespace nlo::trainer
