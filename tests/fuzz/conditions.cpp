// SPDX-License-Identifier: MIT
// Conditions for a comparison, scaled for a plant with two states and one output.
#include "trainer/judge/compare/conditions.h"

#include "tests/fuzz/fuzz.h"

using namespace nlo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzzing::accepts([&] {
    const trainer::ConditionSet set = trainer::parse_conditions(fuzzing::text_of(bytes, size), "c.toml");
    const std::vector<std::pair<std::string, double>> nominal = {{"mu", 1.0}, {"length", 0.5}};
    std::vector<std::string> left_out;
    const trainer::ChannelScales scales = {Eigen::VectorXd::Constant(1, 0.5), Eigen::Vector2d(0.5, 2.0),
                                           Eigen::VectorXd::Constant(1, 0.01)};
    for (const trainer::Condition& condition : trainer::conditions_of(set, nominal, scales, left_out)) {
      (void)trainer::condition_title(condition);
      fuzzing::require(trainer::changed_parameters(condition, nominal, 3).size() == nominal.size(),
                       "a condition keeps the plant's parameters");
    }
  });
  return 0;
}
