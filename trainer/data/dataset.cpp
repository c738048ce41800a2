// SPDX-License-Identifier: MIT
#include "trainer/data/dataset.h"

#include <algorithm>
#include <type_traits>

namespace nlo::trainer {

Trajectory Trajectory::from(Eigen::Index first, Eigen::Index every) const {
  const auto kept = Eigen::seqN(first, (samples() - first + every - 1) / every, every);
  const auto part = [&](const auto& signal) {
    using Signal = std::remove_cvref_t<decltype(signal)>;
    return signal.size() == 0 ? Signal() : Signal(signal(Eigen::all, kept));
  };
  Trajectory result;
  result.source = source;
  result.log = log;
  result.time_s = time_s(kept).array() - time_s(first);
  result.outputs = part(outputs);
  result.states = part(states);
  result.weight = weight(kept);
  result.first_estimate = (std::max<Eigen::Index>(0, first_estimate - first) + every - 1) / every;
  result.derivatives = part(derivatives);
  result.inputs = part(inputs);
  result.unestimated = part(unestimated);
  result.missing = part(missing);
  return result;
}

double Dataset::longest_s() const {
  double longest = 0.0;
  for (const Trajectory& run : trajectories)
    if (run.samples() > 0) longest = std::max(longest, run.time_s[run.samples() - 1]);
  return longest;
}

void Dataset::compute_outputs() {
  const codegen::ComputedOutputs computed(outputs, inputs_read());
  if (computed.none()) return;
  for (Trajectory& run : trajectories) {
    computed.fill(run.outputs, run.inputs);
    if (run.missing.size() == 0) continue;
    for (std::size_t i = 0; i < computed.all().size(); ++i) {
      auto missing = run.missing.row(computed.first() + static_cast<Eigen::Index>(i));
      missing.setConstant(false);
      for (const int part : computed.all()[i].reads())
        if (part < computed.first()) missing = missing || run.missing.row(part);
    }
  }
}

}  // namespace nlo::trainer
