// SPDX-License-Identifier: MIT
// A field of a JSON file, read as a given type. Errors name its place in the file.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "codegen/base/error.h"

namespace nlo::codegen {

using Json = nlohmann::ordered_json;  // provenance keeps its order

/// A value and its place in the file.
struct Field {
  const Json& value;
  std::string path;

  [[noreturn]] void fail(const std::string& what) const { throw Error(path + ": " + what); }

  void expect(bool is_expected, const char* kind) const {
    if (!is_expected) fail(fmt::format("is {}; expected {}", described(), kind));
  }

  std::string described() const {
    return value.is_null() ? "null (not finite when it was written?)" : std::string("a JSON ") + value.type_name();
  }

  Field operator[](const char* key) const {
    expect(value.is_object(), "an object");
    const auto found = value.find(key);
    const std::string name = path.empty() ? key : path + "." + key;
    if (found == value.end()) throw Error(name + ": is missing; export or train the model again");
    return {*found, name};
  }

  /// Returns true if the value has the field `key`; for optional fields.
  bool has(const char* key) const { return value.is_object() && value.contains(key); }

  Field operator[](std::size_t i) const { return {value[i], fmt::format("{}[{}]", path, i)}; }

  std::size_t array_size() const {
    expect(value.is_array(), "an array");
    return value.size();
  }

  void allow_only(const std::vector<const char*>& keys) const {
    expect(value.is_object(), "an object");
    for (const auto& [key, unused] : value.items())
      if (std::none_of(keys.begin(), keys.end(), [&k = key](const char* known) { return k == known; }))
        throw Error(
            fmt::format("{}{}: unknown field; correct its spelling, or update nlo when a newer one wrote the file",
                        path.empty() ? "" : path + ".", Json(key).dump(-1, ' ', true, Json::error_handler_t::replace)));
  }
};

inline double number(const Field& field) {
  field.expect(field.value.is_number(), "a number");
  return field.value.get<double>();
}

inline std::string text(const Field& field) {
  field.expect(field.value.is_string(), "a text");
  return field.value.get<std::string>();
}

inline bool boolean(const Field& field) {
  field.expect(field.value.is_boolean(), "true or false");
  return field.value.get<bool>();
}

inline int small_integer(const Field& field) {
  constexpr int kLargest = 1 << 20;
  field.expect(field.value.is_number_integer(), "an integer");
  const double value = field.value.get<double>();
  if (!(value >= 0 && value <= kLargest)) field.fail(fmt::format("is {}; expected 0 to {}", value, kLargest));
  return static_cast<int>(value);
}

inline Eigen::VectorXd vector(const Field& field) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(field.array_size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) values(i) = number(field[static_cast<std::size_t>(i)]);
  return values;
}

inline Eigen::MatrixXd matrix(const Field& field) {
  Eigen::MatrixXd values;
  const std::size_t rows = field.array_size();
  for (std::size_t i = 0; i < rows; ++i) {
    const Eigen::VectorXd row = vector(field[i]);
    if (i == 0) values.resize(static_cast<Eigen::Index>(rows), row.size());
    if (row.size() != values.cols())
      field[i].fail(
          fmt::format("has {} numbers and the rows above have {}; make them equal", row.size(), values.cols()));
    values.row(static_cast<Eigen::Index>(i)) = row.transpose();
  }
  return values;
}

}  // namespace nlo::codegen
