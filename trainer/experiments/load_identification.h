// SPDX-License-Identifier: MIT
// Reads the file of an identification into a checked value.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/identification.h"
#include "trainer/experiments/shipped.h"

namespace nlo::trainer {

/// Reads and checks an identification. `overrides`: --set SECTION.KEY=VALUE. Throws codegen::Error, `FILE:LINE: reason;
/// remedy`, for unknown keys, expressions that do not compile, and names of the plant that no column of the logs has.
Identification read_identification(const std::string& path, const std::vector<std::string>& overrides = {});
Identification parse_identification(std::string_view text, const std::string& filename,
                                    const std::vector<std::string>& overrides = {});

/// The identifications that the program contains: trainer/experiments/identify/*.toml by their names.
std::span<const ShippedExperiment> shipped_identifications();

/// Returns a text for users with every key that only identifications have, its type, default and meaning.
std::string describe_identify_keys();

}  // namespace nlo::trainer
