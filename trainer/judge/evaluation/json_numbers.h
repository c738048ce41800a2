// SPDX-License-Identifier: MIT
// Numbers in JSON: always finite, else null.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace nlo::trainer {

using Json = nlohmann::ordered_json;

inline Json json_number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
inline Json json_number(const std::optional<double>& value) {
  return value ? json_number(*value) : Json(nullptr);
}

inline Json json_numbers(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(json_number(value));
  return list;
}

/// Replaces bytes that are not UTF-8 (a file name may have any bytes), so that writing does not fail.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace nlo::trainer
