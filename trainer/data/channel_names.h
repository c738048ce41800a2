// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::trainer {

inline std::vector<std::string> channel_names(const std::vector<codegen::Channel>& channels) {
  std::vector<std::string> names;
  for (const codegen::Channel& channel : channels) names.push_back(channel.name);
  return names;
}

}  // namespace nlo::trainer
