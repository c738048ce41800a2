// SPDX-License-Identifier: MIT
// Known equations as C and C++ write them, and the functions that they name as C99.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "codegen/model/equations.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

class EquationLines {
 public:
  /// `part_of_sum` writes a product that is added to something. All three must outlive this.
  EquationLines(const Equations& equations, const Initialiser& init, std::string indent,
                std::function<std::string(const std::string&)> part_of_sum)
      : equations_(equations), init_(init), indent_(std::move(indent)), part_of_sum_(std::move(part_of_sum)) {}

  /// "dx[0] = x[1];" for each state, behind "const float t0 = ...;" for each part that they share.
  std::string derivative() const;
  std::string output() const;  ///< "y[0] = x[0];" for each output

 private:
  std::string lines(const std::vector<Expression>& expressions, const char* left, bool parts) const;

  const Equations& equations_;
  const Initialiser& init_;
  std::string indent_;
  std::function<std::string(const std::string&)> part_of_sum_;
};

/// The functions of templates/c99/functions.c.in that the equations name.
std::string c99_functions(const Equations& equations, const Initialiser& init);

}  // namespace nlo::codegen
