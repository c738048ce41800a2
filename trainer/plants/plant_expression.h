// SPDX-License-Identifier: MIT
// One expression of a user in muParser's language: + - * / ^, sin cos tan asin acos atan atan2 sinh cosh tanh exp ln
// log10 sqrt abs sign min max, a < b ? c : d, with the constant pi. Plants by equations and excitations use it. A part
// of the language is also exported (codegen/model/expression.h), with the same meaning.
#pragma once

#include <muParser.h>

#include <string>
#include <vector>

#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// The names that an expression may use.
struct ExpressionNames {
  std::vector<std::string> variables = {};
  PlantParameters constants = {};
  std::string hint = {};  ///< end of the message about an unknown name or sign
};

/// Makes `parser` evaluate `text`.
///   where   place of the text for messages: "[plant] outputs[0]"
///   values  one value for each variable. Each evaluation reads them, so they must stay at this address as long as the
///           parser exists
/// Throws codegen::Error: WHERE "TEXT": reason and position.
void compile_expression(mu::Parser& parser, const std::string& text, const std::string& where,
                        const ExpressionNames& names, double* values);

}  // namespace nlo::trainer
