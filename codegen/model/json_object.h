// SPDX-License-Identifier: MIT
// A JSON object as a model file writes it: one field per line, one matrix row per line, shortest literals.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/base/number.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

/// Returns the text with quotes and escapes. Throws Error if it is not UTF-8.
std::string json_text(std::string_view text);

/// Returns `[a, b]`. Throws Error if a number is not finite.
template <class Vector>
std::string json_array(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + literal(values(i));
  return text + "]";
}

class JsonObject {
 public:
  explicit JsonObject(std::string indent = "") : indent_(std::move(indent)) {}

  const std::string& inner() const { return inner_; }  ///< indent of its fields
  void field(const char* name, const std::string& value) {
    text_ += std::string(text_.empty() ? "{\n" : ",\n") + inner_ + "\"" + name + "\": " + value;
  }
  void matrix(const char* name, const Eigen::MatrixXd& value);
  void vector(const char* name, const Eigen::VectorXd& value) { field(name, json_array(value)); }
  void text(const char* name, std::string_view value) { field(name, json_text(value)); }
  void channels(const char* name, const std::vector<Channel>& list);
  void dense(const char* name, const DenseLayer& layer);
  void network(const char* name, const Network& network);

  std::string text() const { return text_ + "\n" + indent_ + "}"; }

 private:
  std::string indent_, inner_ = indent_ + "  ", text_;
};

}  // namespace nlo::codegen
