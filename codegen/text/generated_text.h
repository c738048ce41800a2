// SPDX-License-Identifier: MIT
// Text that every generator of C++ headers needs: initialisers with literals of the target's scalar, and user text made
// safe for a comment.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>

#include "codegen/model/model.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// Initialisers of C arrays. Rounds each number once to the scalar; throws Error, naming the field, when one overflows.
class Initialiser {
 public:
  explicit Initialiser(const ExportOptions& options) : scalar_(options.scalar), weights_(options.weights) {}

  const char* scalar_name() const { return scalar_ == ScalarType::kDouble ? "double" : "float"; }
  std::size_t scalar_bytes() const { return scalar_ == ScalarType::kDouble ? 8 : 4; }

  /// Type of a layer's weights, and its bytes.
  const char* weight_type() const {
    return weights_ == WeightType::kFull ? scalar_name() : weights_ == WeightType::kBfloat16 ? "Bfloat16" : "Float16";
  }
  std::size_t weight_bytes() const { return weights_ == WeightType::kFull ? scalar_bytes() : 2; }

  std::string operator()(double value, std::string_view field) const;

  /// `{a, b, c}`
  std::string vector(const Eigen::VectorXd& values, std::string_view field) const;

  /// `{{a, b}, {c, d}}` on one line.
  std::string matrix(const Eigen::MatrixXd& values, std::string_view field) const;

  /// Initialiser with one row per line, each behind `indent` spaces. The last line is the closing brace, two spaces
  /// less.
  std::string rows(const Eigen::MatrixXd& values, int indent, std::string_view field) const;

 private:
  ScalarType scalar_;
  WeightType weights_;
};

/// `  r[4] = r[0] * r[3];` for each output that is computed, of readings r. `part_of_sum` writes a product that is
/// added to something.
std::string computed_statements(const Model& model, const Initialiser& init, const char* indent,
                                const std::function<std::string(const std::string&)>& part_of_sum);

/// At most `longest` characters of a set that can neither end nor continue a `//` comment: others become '_'.
std::string safe_comment(std::string_view text, std::size_t longest);

/// `comment`, lines that begin with `//`, with those of more than 100 columns broken at their last space before.
std::string wrapped_comment(std::string_view comment);

/// A number for people, to four digits: "0.02", "0.3333".
std::string rounded_text(double value);

/// "1 pair", "2 pairs": a number as text, and a noun that takes an s.
std::string counted(std::string_view number, std::string_view noun);

/// 7750 as "7,750".
std::string grouped(Eigen::Index number);

/// `options.name`, or the model's. Throws Error unless it is an identifier that neither C++ nor the runtime has taken.
std::string export_name(const Model& model, const ExportOptions& options);

}  // namespace nlo::codegen
