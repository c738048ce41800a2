// SPDX-License-Identifier: MIT
#include "trainer/choose/mode_banks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/base/draws.h"

namespace nlo::trainer {
namespace {

/// Forms at speed 1. The comment of each names the experiment for which it was found by hand.
const std::vector<ModeBank>& forms() {
  static const std::vector<ModeBank> kForms = {
      {.pairs = {}, .real = {-0.5, -2.0}},                              // car
      {.pairs = {}, .real = {-0.25, -1.0, -4.0}},                       //
      {.pairs = {}, .real = {-0.125, -0.5, -2.0, -8.0}},                // battery, pmsm
      {.pairs = {{-0.33, 1.0}}, .real = {-1.0, -4.0}},                  // Van der Pol
      {.pairs = {{-0.7, 0.7}}, .real = {-1.5, -4.0}},                   // a pendulum upright
      {.pairs = {{-0.2, 0.4}, {-0.45, 0.9}, {-1.0, 2.0}}, .real = {}},  // rotary and double pendulum
      // For states that one sensor does not show: qube_arm, double_pendulum_joint1.
      {.pairs = {{-0.1, 0.2}, {-0.22, 0.45}, {-0.45, 1.0}, {-1.0, 2.2}}, .real = {}},
      {.pairs = {{-0.2, 0.4}, {-1.0, 2.0}}, .real = {-0.05}},  // a slow state beside fast ones
  };
  return kForms;
}

}  // namespace

double ModeBank::slowest() const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [re, im] : pairs) least = std::min(least, -re);
  for (const double lambda : real) least = std::min(least, -lambda);
  return least;
}

double ModeBank::fastest() const {
  double most = 0.0;
  for (const auto& [re, im] : pairs) most = std::max(most, std::hypot(re, im));
  for (const double lambda : real) most = std::max(most, -lambda);
  return most;
}

ModeBank ModeBank::scaled(double faster) const {
  ModeBank result = *this;
  for (auto& pair : result.pairs)
    for (double& part : pair) part = rounded(faster * part);
  for (double& lambda : result.real) lambda = rounded(faster * lambda);
  return result;
}

std::vector<ModeBank> mode_banks(double sample_period_s, double horizon_s, int most_rows) {
  constexpr double kApart = 1.8, kFastest = 1.5;
  int fewest = std::numeric_limits<int>::max();
  for (const ModeBank& form : forms()) fewest = std::min(fewest, form.rows());
  std::vector<ModeBank> banks;
  for (int index = 0; index < static_cast<int>(forms().size()); ++index) {
    ModeBank form = forms()[static_cast<std::size_t>(index)];
    form.form = index;
    if (form.rows() > std::max(most_rows, fewest)) continue;
    const double least = 1.0 / (form.slowest() * horizon_s), most = kFastest / (form.fastest() * sample_period_s);
    for (double speed = least; speed <= most; speed *= kApart) banks.push_back(form.scaled(speed));
  }
  return banks;
}

}  // namespace nlo::trainer
