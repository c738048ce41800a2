// SPDX-License-Identifier: MIT
// The keys of [identify]; those of the other sections are an experiment's.
#pragma once

#include <string_view>
#include <vector>

#include "trainer/config/identification.h"
#include "trainer/config/keys.h"
#include "trainer/experiments/section_keys.h"

namespace nlo::trainer {

template <>
const std::vector<Key<Identification>>& keys();
template <>
std::string_view section_title<Identification>();
template <>
const std::vector<Key<IdentifyConfig>>& keys();
template <>
std::string_view section_title<IdentifyConfig>();

}  // namespace nlo::trainer
