// SPDX-License-Identifier: MIT
// Text for every generator of C++ headers: initialisers with literals of the target's scalar, and text of users that is
// safe in a comment.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>

#include "codegen/model/model.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// Writes initialisers of C arrays. Rounds each number once to the scalar. Throws Error with the field on overflow.
class Initialiser {
 public:
  explicit Initialiser(const ExportOptions& options) : scalar_(options.scalar), weights_(options.weights) {}

  const char* scalar_name() const { return scalar_ == ScalarType::kDouble ? "double" : "float"; }
  std::size_t scalar_bytes() const { return scalar_ == ScalarType::kDouble ? 8 : 4; }

  /// Returns the type of a layer's weights; the next function returns its size in bytes.
  const char* weight_type() const {
    return weights_ == WeightType::kFull ? scalar_name() : weights_ == WeightType::kBfloat16 ? "Bfloat16" : "Float16";
  }
  std::size_t weight_bytes() const { return weights_ == WeightType::kFull ? scalar_bytes() : 2; }

  std::string operator()(double value, std::string_view field) const;

  /// Returns `{a, b, c}`.
  std::string vector(const Eigen::VectorXd& values, std::string_view field) const;

  /// Returns `{{a, b}, {c, d}}` on one line.
  std::string matrix(const Eigen::MatrixXd& values, std::string_view field) const;

  /// Returns an initialiser with one row per line, indented by `indent` spaces. The last line is the closing brace,
  /// indented by two spaces less.
  std::string rows(const Eigen::MatrixXd& values, int indent, std::string_view field) const;

 private:
  ScalarType scalar_;
  WeightType weights_;
};

/// Returns a line such as `  r[4] = r[0] * r[3];` for each computed output. r are the readings. `part_of_sum` writes a
/// product that is a term of a sum.
std::string computed_statements(const Model& model, const Initialiser& init, const char* indent,
                                const std::function<std::string(const std::string&)>& part_of_sum);

/// Returns at most `longest` characters. Characters that could end or continue a `//` comment become '_'.
std::string safe_comment(std::string_view text, std::size_t longest);

/// Breaks the lines of a `//` comment at a space, so that they fit 100 columns.
std::string wrapped_comment(std::string_view comment);

/// Returns a number with four digits for readers: "0.02", "0.3333".
std::string rounded_text(double value);

/// Returns "1 pair", "2 pairs": a number as text and a noun, with an s for the plural.
std::string counted(std::string_view number, std::string_view noun);

/// Returns 7750 as "7,750".
std::string grouped(Eigen::Index number);

/// Returns `options.name`, or the model's name. Throws Error unless it is an identifier that C++ and the runtime do not
/// use.
std::string export_name(const Model& model, const ExportOptions& options);

}  // namespace nlo::codegen
