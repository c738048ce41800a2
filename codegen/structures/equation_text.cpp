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
#include "codegen/text/flown_number.h"

namespace nlo::codegen {
namespace {

constexpr std::string_view kMinimum = "minimum", kMaximum = "maximum";

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

}  // namespace

std::string EquationLines::derivative() const {
  return lines(equations_.derivative().parts, "", true) + lines(equations_.derivative().rows, "dx", false);
}

std::string EquationLines::output() const {
  return lines(equations_.output().parts, "", true) + lines(equations_.output().rows, "y", false);
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

std::set<std::string_view> functions_of(const Equations& equations) {
  std::set<std::string_view> named;
  const auto add = [&](const std::vector<Expression>& expressions) {
    for (const Expression& expression : expressions)
      for (const Expression::Node& node : expression.nodes()) {
        if (node.kind == Expression::Kind::kFunction) named.insert(row_of(node.function).runtime);
        if (node.kind == Expression::Kind::kMinimum) named.insert(kMinimum);
        if (node.kind == Expression::Kind::kMaximum) named.insert(kMaximum);
      }
  };
  for (const SharedExpressions* shared : {&equations.derivative(), &equations.output()}) {
    add(shared->parts);
    add(shared->rows);
  }
  return named;
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
  values["CIRCLE"] = values["SINE"] + values["COSINE"];
  return filled(embedded_text("c99/functions.c.in"), values);
}

}  // namespace nlo::codegen
