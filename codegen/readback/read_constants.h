// SPDX-License-Identifier: MIT
// The constants of generated C99 and C++ text, read back by their names: what a compiler would make of it, told by
// none of the code that wrote it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::codegen {

/// One value as it stands in the text: a number with its sign, a word, or an expression without spaces.
struct ReadValue {
  std::string text;
  int line;
  std::size_t at;  ///< in the whole text
};

/// One array, number or word. `path` is what the text calls it:
///   kEigenvalues, kNz, output_y       of C99, without the export's own name before it; also an enumerator
///   kStep.a_minus_1                   a field of a constant structure, whose type the text declares
///   advance.kParts                    of the function `advance`
///   estimate#2                        the second call in it that passes two constants: function, arguments
///   kModel.latent.eigenvalues         of C++, by its designators
///   weights::kLayer1.type             the template and its arguments, of a constant with such a type or of an alias
struct ReadConstant {
  std::string path;
  std::vector<std::size_t> shape;  ///< of the braces; empty: none
  std::vector<ReadValue> values;   ///< row by row
  int line;
};

/// `name` of the export. Throws Error, naming the line, for text that is not of the forms that exports have.
std::vector<ReadConstant> read_constants(std::string_view text, const std::string& name);

}  // namespace nlo::codegen
