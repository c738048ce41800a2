// SPDX-License-Identifier: MIT
#include "codegen/structures/equation_text.h"

#include <fmt/format.h>
#include <nlo/functions.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

#include "codegen/base/embedded_text.h"
#include "codegen/base/number.h"
#include "codegen/base/replaced.h"
#include "codegen/text/flown_number.h"

namespace nlo::codegen {
namespace {

constexpr std::string_view kMinimum = "minimum", kMaximum = "maximum", kSine = "sine", kCosine = "cosine",
                           kCircle = "circle";

/// The numbers of nlo/functions.h.
template <class T>
std::map<std::string, std::string> numbers() {
  constexpr bool kSingle = sizeof(T) == 4;
  constexpr CircleFit<T> kFit;
  using Limits = std::numeric_limits<T>;
  const auto list = [](const auto& values) {
    std::string text;
    for (const T value : values) text += (text.empty() ? "" : ", ") + literal(value);
    return "{" + text + "}";
  };
  const auto number = [](double value) { return literal(static_cast<T>(value)); };
  return {{"F", kSingle ? "f" : ""},
          {"BITS", kSingle ? "uint32_t" : "uint64_t"},
          {"NOT_A_NUMBER", kSingle ? "0x7fc00000U" : "0x7ff8000000000000U"},
          {"QUARTER", list(kFit.quarter)},
          {"SINE_SERIES", list(kFit.sine)},
          {"COSINE_SERIES", list(kFit.cosine)},
          {"TERMS", std::to_string(kFit.kTerms)},
          {"TO_QUARTERS", number(0.63661977236758134308)},
          {"TO_DOUBLINGS", number(1.44269504088896340736)},
          {"REST_OF_LOG_2", number(1.42860682030941723212e-6)},
          {"EXP_TERMS", kSingle ? "7" : "13"},
          {"BIAS", std::to_string(Limits::max_exponent - 1)},
          {"FRACTION", std::to_string(Limits::digits - 1)},
          {"SMALLEST", literal(Limits::min())},
          {"LARGEST_NUMBER", literal(Limits::max())},
          {"ROOT_OF_2", literal(T(2) * T(0.70710678118654752440))},
          {"LOG_2", number(0.69314718055994530942)},
          {"ROOT_LINE", kSingle ? "0x5f3759dfU" : "0x5fe6eb50c7b537a9U"},
          {"ROOT_ROUNDS", kSingle ? "3" : "4"},
          {"TAN_3", number(2.4142135623730950488)},
          {"TAN_1", number(0.41421356237309504880)},
          {"HALF_PI", number(1.57079632679489661923)},
          {"QUARTER_PI", number(0.78539816339744830962)},
          {"ATAN_LAST", kSingle ? "19.0f" : "41.0"},
          {"ATAN_TERMS", kSingle ? "8" : "19"}};
}

/// Returns the arguments of the calls of a function, in the order of the text.
std::vector<std::string> arguments_of(const std::string& text, std::string_view function) {
  std::vector<std::string> arguments;
  const std::string head = fmt::format("{}(", function);
  for (std::size_t at = text.find(head); at != std::string::npos; at = text.find(head, at + 1)) {
    const char before = at > 0 ? text[at - 1] : ' ';
    if (before == '_' || std::isalpha(static_cast<unsigned char>(before)) != 0) continue;  // the end of a longer name
    const std::size_t begin = at + head.size();
    std::size_t end = begin;
    for (int open = 1; open > 0; ++end) open += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
    arguments.push_back(text.substr(begin, end - 1 - begin));
  }
  return arguments;
}

}  // namespace

std::string EquationLines::derivative() const {
  return lines(equations_.derivative(), "dx");
}

std::string EquationLines::output() const {
  return lines(equations_.output(), "y");
}

std::string EquationLines::lines(const SharedExpressions& shared, const char* left) const {
  return with_circles(lines(shared.parts, "", true) + lines(shared.rows, left, false));
}

std::string EquationLines::with_circles(std::string text) const {
  int circles = 0;
  for (const std::string& argument : arguments_of(text, kSine)) {
    const std::string cosine = fmt::format("{}({})", kCosine, argument);
    if (text.find(cosine) == std::string::npos) continue;
    const std::string sine = fmt::format("{}({})", kSine, argument), name = fmt::format("circle{}", circles++);
    const std::size_t first_use = text.find(sine);  // this text is in that of the cosine, too
    const std::size_t line = text.rfind('\n', first_use) + 1;
    text = replaced(replaced(text, cosine, name + ".cosine"), sine, name + ".sine");
    text.insert(line, fmt::format("{}const {} {} = {}({});\n", indent_, circle_type_, name, kCircle, argument));
  }
  return text;
}

std::string EquationLines::lines(const std::vector<Expression>& expressions, const char* left, bool parts) const {
  const auto reading = [this](int j) {
    if (j < equations_.first_input()) return fmt::format("x[{}]", j);
    if (j < equations_.first_parameter()) return fmt::format("u[{}]", j - equations_.first_input());
    if (j >= equations_.first_part()) return fmt::format("t{}", j - equations_.first_part());
    return init_(equations_.parameter(j - equations_.first_parameter()), "equations.parameters");
  };
  const auto number = [this](double value) { return init_(value, "equations"); };
  std::string text;
  for (std::size_t i = 0; i < expressions.size(); ++i) {
    const std::string name =
        parts ? fmt::format("const {} t{}", init_.scalar_name(), i) : fmt::format("{}[{}]", left, i);
    text += fmt::format("{}{} = {};\n", indent_, name, expressions[i].text(reading, number, part_of_sum_, parts));
  }
  return text;
}

std::set<std::string_view> functions_called_in(const std::string& text) {
  std::set<std::string_view> called;
  const auto add = [&](std::string_view function) {
    if (!arguments_of(text, function).empty()) called.insert(function);
  };
  for (const FunctionRow& row : all_functions()) add(row.runtime);
  for (const std::string_view function : {kMinimum, kMaximum, kCircle}) add(function);
  return called;
}

std::string c99_functions(const std::set<std::string_view>& named, const Initialiser& init) {
  if (named.empty()) return "";
  auto values = init.scalar_bytes() == 4 ? numbers<float>() : numbers<double>();
  const auto set = [&](std::string_view function) {
    std::string key(function);
    for (char& c : key) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    values[key] = named.contains(function) ? "true" : "";
  };
  for (const FunctionRow& row : all_functions()) set(row.runtime);
  set(kMinimum);
  set(kMaximum);
  values["CIRCLE"] = named.contains(kCircle) || named.contains(kSine) || named.contains(kCosine) ? "true" : "";
  return filled(embedded_text("c99/functions.c.in"), values);
}

}  // namespace nlo::codegen
