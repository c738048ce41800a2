// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/plants/odd_plant.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw KeyError("training.mirror", "[training] mirror " + why);
}

/// Checks that a column and the column whose derivative it is change their signs together.
void check_derivatives(const std::vector<std::string>& odd, const LogConfig& log) {
  const auto is_odd = [&](const std::string& name) { return std::ranges::find(odd, name) != odd.end(); };
  for (const ColumnConfig& column : log.columns)
    for (const ColumnConfig& source : log.columns)
      if (source.name == column.derivative_of && source.derivative_of.empty() &&
          is_odd(column.name) != is_odd(source.name))
        refuse(
            fmt::format("changes the sign of only one of {} and {}, but one is the derivative of the other; set the "
                        "same odd for both",
                        column.name, source.name));
}

}  // namespace

void check_mirror(const Experiment& e) {
  if (!e.training.mirror) return;
  const std::vector<std::string> odd = mirrored_channels(e);
  if (odd.empty())
    refuse(
        "= true: every channel is declared even (odd = false), so a mirror image equals the run; set mirror = "
        "false");
  if (e.log) return check_derivatives(odd, *e.log);
  if (const auto found = mirror_counterexample(*make_plant(*e.plant), odd, e.simulation, e.moves_inputs()))
    refuse(fmt::format("= true: the plant is not odd: {}; {}set mirror = false", *found,
                       e.plant->even.empty() ? "name the channels that keep their sign in [plant] even, or " : ""));
}

}  // namespace nlo::trainer
