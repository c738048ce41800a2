// SPDX-License-Identifier: MIT
#include "trainer/learn/training/readout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace nlo::trainer {

double StateSquares::blend(std::size_t c, double share) const {
  return share * share * map + 2.0 * share * (1.0 - share) * both[c] + (1.0 - share) * (1.0 - share) * row[c];
}

std::string readout_text(const StateReadout& state) {
  if (state.reach > 0.0) return "network with fallback";
  const double share = state.share;
  return share == 1.0 ? "network" : share == 0.0 ? "linear row" : fmt::format("{:.2f} network", share);
}

std::string readout_fact(const Readout& readout, std::size_t left_out) {
  std::vector<std::pair<std::string, std::string>> groups;  // the readout, and the states that have it
  for (const StateReadout& state : readout) {
    const std::string text = readout_text(state);
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == text; });
    if (found == groups.end())
      groups.emplace_back(text, state.state);
    else
      found->second += ", " + state.state;
  }
  const std::string by = left_out == 0 ? "" : fmt::format(" (by {} groups of logs that were left out)", left_out);
  if (groups.size() == 1) return groups.front().first + by;
  std::string text;
  for (const auto& [what, states] : groups) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", what, states);
  return text + by;
}

std::string below_floor(const Readout& readout) {
  constexpr double kWorse = 1.05, kOfDeviation = 0.005;
  std::string text;
  for (const StateReadout& s : readout) {
    struct Simple {
      double error;
      std::string name;
    };
    const Simple simple =
        std::min({Simple{s.linear, "a linear row on the inputs of T*"}, Simple{s.constant, "its mean"},
                  Simple{s.sensor, "output " + s.sensor_name + " as it is"}},
                 [](const Simple& a, const Simple& b) { return a.error < b.error; });
    if (s.shipped <= kWorse * simple.error || s.shipped - simple.error <= kOfDeviation * s.deviation) continue;
    text += fmt::format("{}{} has an RMSE of {:.3g}, {} has {:.3g}", text.empty() ? "" : "; ", s.state, s.shipped,
                        simple.name, simple.error);
  }
  if (text.empty()) return text;
  return "the observer is worse than a simpler estimate: " + text +
         ". The model is kept. Let T* read the output ([observer] features = \"latent_and_output\"), spread the "
         "eigenvalues about the plant's own time constants, or train for more steps";
}

}  // namespace nlo::trainer
