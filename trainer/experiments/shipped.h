// SPDX-License-Identifier: MIT
// The experiments that `nlo` contains, by their names: "qube" is trainer/experiments/qube.toml. Those of the paper are
// in `nlo-reproduce` (trainer/reproduce/planned_trainings.h).
#pragma once

#include <span>
#include <string_view>

namespace nlo::trainer {

struct ShippedExperiment {
  std::string_view name, text;
};

std::span<const ShippedExperiment> shipped_experiments();

}  // namespace nlo::trainer
