// SPDX-License-Identifier: MIT
#include "codegen/readback/formula_text.h"

#include <algorithm>
#include <cstdlib>

#include "codegen/base/fail.h"
#include "codegen/model/expression_values.h"
#include "codegen/readback/read_number.h"
#include "codegen/readback/token_stream.h"

namespace nlo::codegen {
namespace {

/// expression = term {(+ | -) term}, term = factor {(* | /) factor}
class Formula {
 public:
  Formula(const ReadFunction& function, bool single, Quantity::Arrays& arrays)
      : in_(function.body), single_(single), arrays_(arrays) {}

  void run() {
    in_.expect("{");
    while (!in_.accept("}")) statement();
  }

 private:
  void statement() {
    if (in_.at("(")) {  // (void)u;
      in_.skip_balanced();
      (void)in_.take();
      return in_.expect(";");
    }
    if (in_.accept("const")) {
      (void)in_.take();
      const std::string name = in_.take().text;
      in_.expect("=");
      locals_[name] = expression();
    } else {
      double& to = element(in_.take());
      in_.expect("=");
      to = expression();
    }
    in_.expect(";");
  }

  double& element(const Token& array) {
    in_.expect("[");
    const Token at = in_.take();
    in_.expect("]");
    const auto found = arrays_.find(array.text);
    const std::size_t index = std::strtoul(at.text.c_str(), nullptr, 10);
    if (found == arrays_.end() || at.kind != Token::Kind::kNumber || index >= found->second.size())
      fail("line {}: {}[{}] is not there", array.line, array.text, at.text);
    return found->second[index];
  }

  double expression() {
    double sum = term();
    while (in_.at("+") || in_.at("-")) {
      const bool plus = in_.take().is("+");
      const double next = term();
      sum = plus ? sum + next : sum - next;
    }
    return sum;
  }

  double term() {
    double product = factor();
    while (in_.at("*") || in_.at("/")) {
      const bool times = in_.take().is("*");
      const double next = factor();
      product = times ? product * next : product / next;
    }
    return product;
  }

  double factor() {
    if (in_.accept("-")) return -factor();
    if (in_.accept("(")) {
      const double value = expression();
      in_.expect(")");
      return value;
    }
    const Token token = in_.take();
    if (token.kind == Token::Kind::kNumber) {
      const std::optional<double> number =
          single_ ? std::optional<double>(read_number<float>(token.text)) : read_number<double>(token.text);
      if (!number) fail("line {}: {} is not a number", token.line, token.text);
      return *number;
    }
    if (in_.at("[")) return element(token);
    if (const auto local = locals_.find(token.text); local != locals_.end()) return local->second;
    if (token.is("rounded")) in_.skip_past(">");
    in_.expect("(");
    const double argument = expression();
    in_.expect(")");
    if (token.is("rounded")) return argument;
    const auto rows = all_functions();
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const FunctionRow& r) { return r.runtime == token.text; });
    if (row == rows.end()) fail("line {}: {} is not known", token.line, token.text);
    return value_of(row->function, argument);
  }

  TokenStream in_;
  bool single_;
  Quantity::Arrays& arrays_;
  std::map<std::string, double> locals_;
};

}  // namespace

void run_formula(const ReadFunction& function, bool single, Quantity::Arrays& arrays) {
  Formula(function, single, arrays).run();
}

}  // namespace nlo::codegen
