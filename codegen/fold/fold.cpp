// SPDX-License-Identifier: MIT
#include "codegen/fold/fold.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/model/computed_outputs.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

int stale_after(const Model& m) {
  constexpr double kFewest = 5.0, kMost = 16383.0;  // range of the runtime's counter
  constexpr int kUnknown = 10;
  const std::optional<double> fastest = module_of(m).fastest_mode(m);
  if (!fastest) return kUnknown;
  return static_cast<int>(std::clamp(std::round(1.0 / (*fastest * m.sample_period_s)), kFewest, kMost));
}

std::vector<int> not_due(const Model& m) {
  std::vector<int> samples = not_due(m.outputs, m.inputs, m.sample_period_s);
  samples.resize(static_cast<std::size_t>(m.nr()), 0);
  return samples;
}

std::vector<int> not_due(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs,
                         double sample_period_s) {
  constexpr double kRounding = 0.05;                            // sample periods
  std::vector<int> samples(outputs.size() + inputs.size(), 0);  // computed outputs may read inputs
  for (std::size_t j = 0; j < outputs.size(); ++j)
    if (outputs[j].period_s > 0.0)
      samples[j] = static_cast<int>(std::ceil(outputs[j].period_s / sample_period_s - kRounding)) - 1;
  const ComputedOutputs computed(outputs, inputs);
  for (std::size_t i = 0; i < computed.all().size(); ++i)
    for (const int part : computed.all()[i].reads()) {
      int& of_sum = samples[static_cast<std::size_t>(computed.first()) + i];
      of_sum = std::max(of_sum, samples[static_cast<std::size_t>(part)]);
    }
  return samples;
}

int most_missing(int not_due) {
  return not_due + (not_due + 1) / 2;
}

bool has_slow_outputs(const Model& m) {
  return std::ranges::any_of(m.outputs, [](const Channel& output) { return output.period_s > 0.0; });
}

FoldedModel fold(const Model& m) {
  FoldedModel folded;
  for (const Named<const Network>& n : networks(m)) {
    folded.networks.push_back(fold(*n.network, n.reads));
    folded.networks.back().field = n.field;
  }
  if (linear_latent(m) != nullptr) folded.step = latent_step(m, m.sample_period_s);
  folded.steady_gain = steady_gain(m);
  folded.stale_after = stale_after(m);
  folded.ranges = flown_ranges(m);
  if (m.error) folded.error = fold(*m.error);
  return folded;
}

}  // namespace nlo::codegen
