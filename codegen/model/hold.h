// SPDX-License-Identifier: MIT
// Names of the holds (nlo/latent.h) in files and messages.
#pragma once

#include <nlo/latent.h>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

namespace nlo::codegen {

inline constexpr std::array<std::pair<Hold, std::string_view>, 3> kHoldNames = {
    {{Hold::kZeroOrder, "zero_order"}, {Hold::kFirstOrder, "first_order"}, {Hold::kRk4, "rk4"}}};

constexpr std::string_view hold_name(Hold hold) {
  for (const auto& [value, name] : kHoldNames)
    if (value == hold) return name;
  return {};
}

/// Returns nothing for an unknown name.
constexpr std::optional<Hold> find_hold(std::string_view name) {
  for (const auto& [value, known] : kHoldNames)
    if (known == name) return value;
  return std::nullopt;
}

}  // namespace nlo::codegen
