// SPDX-License-Identifier: MIT
// The keys of [identify]. The other sections of an identification have the keys of an experiment.
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
