// SPDX-License-Identifier: MIT
#include "trainer/plants/plant_expression.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kLongestExpression = 4000;  // muParser refuses 5,000 characters without naming the text

/// muParser reads "x1 = 2" as an assignment to the state, which an expression must not contain.
bool assigns(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) {
      return true;
    }
  }
  return false;
}

bool uses_name(const ExpressionNames& names, std::string_view name) {
  return std::any_of(names.variables.begin(), names.variables.end(), [&](const auto& v) { return v == name; }) ||
         std::any_of(names.constants.begin(), names.constants.end(), [&](const auto& c) { return c.first == name; });
}

/// Returns muParser's message without its position, which counts from 0.
std::string words_of(const mu::ParserError& error) {
  std::string words = error.GetMsg();
  for (const char* position : {" found at position", " at position"})
    if (const auto at = words.find(position); at != std::string::npos) words.erase(at);
  return words;
}

}  // namespace

void compile_expression(mu::Parser& parser, const std::string& text, const std::string& where,
                        const ExpressionNames& names, double* values) {
  const auto fail = [&](const std::string& what) {
    throw codegen::Error(fmt::format("{} \"{}\": {}", where, text, what));
  };
  if (text.find_first_not_of(" \t\n") == std::string::npos) fail("the expression is empty; write a number, or a name");
  if (text.size() > kLongestExpression)
    throw codegen::Error(
        fmt::format("{} has {} characters; at most {} are allowed", where, text.size(), kLongestExpression));
  if (assigns(text)) fail("an expression cannot contain \"=\"; write only the right-hand side; comparisons use ==");
  try {
    parser.ClearConst();  // removes muParser's own _pi and _e
    if (!uses_name(names, "pi")) parser.DefineConst("pi", 3.141592653589793);
    for (std::size_t i = 0; i < names.variables.size(); ++i) parser.DefineVar(names.variables[i], values + i);
    for (const auto& [name, value] : names.constants) parser.DefineConst(name, value);
    parser.SetExpr(text);
    int count = 0;
    parser.Eval(count);
    if (count != 1) fail(fmt::format("it has {} values, separated by commas; give one", count));
  } catch (const mu::ParserError& error) {
    const auto position = error.GetPos() < 0 ? std::string() : fmt::format(" at position {}", error.GetPos() + 1);
    fail(fmt::format("{}{}; variables: {}; functions as in C (sin, exp, ...), powers by ^{}", words_of(error), position,
                     fmt::join(names.variables, ", "), names.hint));
  }
}

}  // namespace nlo::trainer
