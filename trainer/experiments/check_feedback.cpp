// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/state_feedback.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& what) {
  throw KeyError(key.empty() ? "feedback" : "feedback." + key,
                 fmt::format("[feedback]{}{}{}", key.empty() ? "" : " ", key, what));
}

void check_limits(const FeedbackConfig& feedback, const std::vector<codegen::Channel>& inputs) {
  for (const auto& [key, given] :
       {std::pair{"actuator_low", &feedback.actuator_low}, std::pair{"actuator_high", &feedback.actuator_high}}) {
    if (given->empty())
      refuse("", fmt::format(" has no {}; give one for each of the {} inputs: the limit of its actuator", key,
                             inputs.size()));
    if (given->size() != inputs.size())
      refuse(key, fmt::format(" has {} numbers, but the plant has {} inputs; give one for each", given->size(),
                              inputs.size()));
  }
  for (std::size_t j = 0; j < inputs.size(); ++j)
    if (!(feedback.actuator_low[j] < feedback.actuator_high[j]))
      refuse("actuator_high",
             fmt::format("[{0}] is {1}; it must be above actuator_low[{0}], {2}", j,
                         shortest_text(feedback.actuator_high[j]), shortest_text(feedback.actuator_low[j])));
}

void check_names(const Plant& plant) {
  for (const auto& input : plant.inputs())
    for (const auto& state : plant.states())
      if (state.name == reference_name(input.name))
        refuse("law", fmt::format(" cannot tell the state {} from the reference of {}; rename the state", state.name,
                                  input.name));
}

/// Checks the requirements of the closed loop on the observer and on the training.
void check_loop(const Experiment& e) {
  for (const auto* encodings : {&e.plant->state_encodings, &e.plant->output_encodings})
    if (std::find(encodings->begin(), encodings->end(), Encoding::kSincos) != encodings->end())
      refuse("",
             " needs angles without sine and cosine; leave state_encodings and output_encodings out of "
             "[plant]");
  if (!structure_of(e.observer).reads_inputs())
    refuse("", fmt::format(" needs an observer that reads u, but structure \"{}\" does not; use \"kkl\"",
                           e.observer.structure));
  if (e.observer.input_hold != Hold::kZeroOrder)
    throw KeyError("observer.input_hold",
                   "[observer] input_hold = \"first_order\" needs the next u, which [feedback] only knows at the next "
                   "sample; use \"zero_order\"");
  if (e.training.transient == Transient::kBackward)
    throw KeyError("training.transient",
                   "[training] transient = \"backward\" needs a plant without inputs, to simulate its past, but there "
                   "is [feedback]; use \"drop\"");
}

}  // namespace

void check_feedback(const Experiment& e) {
  if (!e.feedback) return;
  const FeedbackConfig& feedback = *e.feedback;
  const auto plant = make_plant(*e.plant);
  if (plant->nu() == 0)
    refuse("", fmt::format(" needs inputs, but the plant {} has none; name them in [plant] inputs, or remove it",
                           plant->name()));
  if (feedback.law.size() != plant->inputs().size())
    refuse(feedback.law.empty() ? "" : "law",
           fmt::format(" has {} laws, but the plant has {} inputs; give one for each: law = [\"-2*{}\"]",
                       feedback.law.size(), plant->inputs().size(), plant->states().front().name));
  check_limits(feedback, plant->inputs());
  check_names(*plant);
  if (!feedback.error.empty() && feedback.error.size() != plant->states().size())
    refuse("error", fmt::format(" has {} numbers, but the plant has {} states; give one for each",
                                feedback.error.size(), plant->states().size()));
  try {
    StateFeedback(feedback, *plant, *e.plant);
  } catch (const codegen::Error& error) {
    throw KeyError("feedback.law", error.what());
  }
  try {
    if (!feedback.cost.empty()) LoopCost(feedback, *plant, e.plant->parameters);
  } catch (const codegen::Error& error) {
    throw KeyError("feedback.cost", error.what());
  }
  check_loop(e);
}

}  // namespace nlo::trainer
