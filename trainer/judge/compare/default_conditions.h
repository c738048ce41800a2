// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace nlo::trainer {

/// The text of conditions.toml.
extern const std::string_view kDefaultConditions;

}  // namespace nlo::trainer
