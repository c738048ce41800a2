// SPDX-License-Identifier: MIT
#include "trainer/data/mirror.h"

#include <algorithm>

namespace nlo::trainer {
namespace {

std::vector<bool> odd_rows(const std::vector<std::string>& odd, const std::vector<codegen::Channel>& channels) {
  std::vector<bool> rows(channels.size(), false);
  const auto mark = [&](const std::string& name) {
    const auto found = std::ranges::find(channels, name, &codegen::Channel::name);
    if (found == channels.end()) return false;
    rows[static_cast<std::size_t>(found - channels.begin())] = true;
    return true;
  };
  for (const std::string& name : odd)
    if (!mark(name)) mark(name + "_sin");
  return rows;
}

}  // namespace

Mirror mirror_of(const std::vector<std::string>& odd, const std::vector<codegen::Channel>& readings,
                 const std::vector<codegen::Channel>& states) {
  if (odd.empty()) return {};
  return {odd_rows(odd, readings), odd_rows(odd, states)};
}

void widen_by_mirror(const Mirror& mirror, Eigen::VectorXd& low, Eigen::VectorXd& high) {
  if (mirror.none()) return;
  for (Eigen::Index row = 0; row < low.size(); ++row) {
    if (!mirror.readings[static_cast<std::size_t>(row)] || low(row) > high(row)) continue;
    high(row) = std::max(high(row), -low(row));
    low(row) = -high(row);
  }
}

}  // namespace nlo::trainer
