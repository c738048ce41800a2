// SPDX-License-Identifier: MIT
// The constants and functions of generated C99 and C++ text, read back by their names: what a compiler would make of
// it, told by none of the code that wrote it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/readback/tokens.h"

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
///   namespace                         the outermost
///   weights::kLayer1.type             the template and its arguments, of a constant with such a type or of an alias
struct ReadConstant {
  std::string path;
  std::vector<std::size_t> shape;  ///< of the braces; empty: none
  std::vector<ReadValue> values;   ///< row by row
  int line;
};

/// A function, called as the constants are. `body`: its words and marks within the braces, without the constants that
/// are declared in it.
struct ReadFunction {
  std::string path;
  std::vector<Token> body;
  int line;
};

struct ReadText {
  std::vector<ReadConstant> constants;
  std::vector<ReadFunction> functions;
};

/// `name` of the export. Throws Error, naming the line, for text that is not of the forms that exports have.
ReadText read_text(std::string_view text, const std::string& name);

}  // namespace nlo::codegen
