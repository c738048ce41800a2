// SPDX-License-Identifier: MIT
// Writes known equations in C and C++, and the functions that they call in C99.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/equations.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

class EquationLines {
 public:
  /// `circle_type`: type of a sine together with its cosine. `part_of_sum` writes a product that is added to a sum.
  /// `equations` and `init` must outlive this object.
  EquationLines(const Equations& equations, const Initialiser& init, std::string indent, std::string circle_type,
                std::function<std::string(const std::string&)> part_of_sum)
      : equations_(equations),
        init_(init),
        indent_(std::move(indent)),
        circle_type_(std::move(circle_type)),
        part_of_sum_(std::move(part_of_sum)) {}

  /// Returns "dx[0] = x[1];" for each state, after "const float t0 = ...;" for each shared part.
  std::string derivative() const;
  std::string output() const;  ///< "y[0] = x[0];" for each output

 private:
  std::string lines(const SharedExpressions& shared, const char* left) const;
  std::string lines(const std::vector<Expression>& expressions, const char* left, bool parts) const;
  /// Lets one call compute the sine and the cosine of the same argument. The slope of a sine is a cosine, so nearly
  /// all equations with one need both.
  std::string with_circles(std::string text) const;

  const Equations& equations_;
  const Initialiser& init_;
  std::string indent_, circle_type_;
  std::function<std::string(const std::string&)> part_of_sum_;
};

/// Returns the names of the functions of nlo/functions.h that the text of equations calls.
std::set<std::string_view> functions_called_in(const std::string& text);

/// Returns the C99 text of these functions of nlo/functions.h.
std::string c99_functions(const std::set<std::string_view>& named, const Initialiser& init);

}  // namespace nlo::codegen
