// SPDX-License-Identifier: MIT
// The experiments that the program carries: trainer/experiments/*.toml by their names, and those of the paper as
// "paper/NAME".
#pragma once

#include <span>
#include <string_view>

namespace nlo::trainer {

struct ShippedExperiment {
  std::string_view name, text;
};

std::span<const ShippedExperiment> shipped_experiments();

}  // namespace nlo::trainer
