// SPDX-License-Identifier: MIT
#include "codegen/model/expression.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/ranges.h>

#include "codegen/base/fail.h"

namespace nlo::codegen {

/// Parses sums, products and powers recursively, and appends the nodes in the order of evaluation.
class ExpressionParser {
 public:
  using Kind = Expression::Kind;

  ExpressionParser(std::string_view text, const std::vector<std::string>& names, Expression::Language language,
                   Expression& result)
      : text_(text),
        names_(names),
        functions_(language == Expression::Language::kFunctions),
        most_nodes_(functions_ ? Expression::kMostNodesOfEquation : Expression::kMostNodes),
        nodes_(result.nodes_) {
    sum();
    if (!at_end()) refuse("an operator (+ - * /) or the end");
  }

 private:
  static constexpr int kMostPower = 4;
  static constexpr int kMostNested = 16;

  [[noreturn]] void refuse(const char* expected) {
    skip_space();
    const std::string_view rest = text_.substr(at_);
    fail("expression \"{}\": at {}: expected {}", text_, rest.empty() ? "its end" : fmt::format("\"{}\"", rest),
         expected);
  }
  void skip_space() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  bool at_end() {
    skip_space();
    return at_ == text_.size();
  }
  bool take(char c) {
    if (at_end() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void append(Kind kind, double number = 0.0, int reading = 0) { append(Expression::Node{kind, number, reading}); }
  void append(const Expression::Node& node) {
    if (nodes_.size() == most_nodes_)
      fail("expression \"{}\" is too long: {} may have {} numbers, names and operations", text_,
           functions_ ? "an equation" : "a computed output", most_nodes_);
    nodes_.push_back(node);
  }

  void sum() {
    if (++nested_ > kMostNested) refuse("fewer parentheses");
    product();
    for (;;) {
      const bool plus = take('+');
      if (!plus && !take('-')) break;
      product();
      append(plus ? Kind::kSum : Kind::kDifference);
    }
    --nested_;
  }

  void product() {
    factor();
    for (;;) {
      const bool times = take('*');
      if (!times && !take('/')) return;
      if (times) {
        factor();
      } else if (functions_) {
        if (divides()) continue;
      } else {
        const double divisor = number("a number other than 0; a measured value may be 0, so it cannot be a divisor");
        if (divisor == 0.0) refuse("a number other than 0 before this");
        append(Kind::kNumber, 1.0 / divisor);
      }
      append(Kind::kProduct);
    }
  }

  /// Parses a division. Multiplying by the reciprocal of a number would round differently.
  bool divides() {
    const std::size_t first = nodes_.size();
    factor();
    const bool by_number = nodes_.size() == first + 1 && nodes_.back().kind == Kind::kNumber;
    if (by_number && nodes_.back().number == 0.0) refuse("a number other than 0 before this");
    if (by_number) nodes_.back().number = 1.0 / nodes_.back().number;
    if (!by_number) append(Kind::kQuotient);
    return !by_number;
  }

  void factor() {
    const bool negative = take('-');
    const std::size_t first = nodes_.size();
    if (take('(')) {
      sum();
      if (!take(')')) refuse("\")\"");
    } else if (!at_end() && (std::isalpha(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_')) {
      name();
    } else {
      append(Kind::kNumber, number("a number, the name of a measured output or input, or \"(\""));
    }
    if (take('^')) power(first);
    if (!negative) return;
    append(Kind::kNumber, -1.0);
    append(Kind::kProduct);
  }

  /// Reads a power from 1 to 4 and raises the sub-expression that starts at node `first` to it, by repeated products.
  void power(std::size_t first) {
    skip_space();
    const int power = at_ < text_.size() ? text_[at_] - '0' : 0;
    if (power < 1 || power > kMostPower) refuse("a whole power from 1 to 4");
    ++at_;
    const std::vector<Expression::Node> base(nodes_.begin() + static_cast<std::ptrdiff_t>(first), nodes_.end());
    for (int i = 1; i < power; ++i) {
      for (const Expression::Node& node : base) append(node);
      append(Kind::kProduct);
    }
  }

  /// Parses a reading, a function with its argument in parentheses, or pi.
  void name() {
    std::size_t end = at_;
    while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) != 0 || text_[end] == '_'))
      ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    const auto found = std::find(names_.begin(), names_.end(), word);
    if (found != names_.end()) {
      at_ = end;
      return append(Kind::kReading, 0.0, static_cast<int>(found - names_.begin()));
    }
    if (functions_ && function(word, end)) return;
    std::vector<std::string> known = names_;
    std::erase(known, "");  // empty names stand for readings that must not be read
    fail("expression \"{}\" reads \"{}\": expected a measured output that does not wrap, or an input{}; there is {}",
         text_, word, functions_ ? ", or a function (" + function_names() + ", tan, min, max)" : "",
         fmt::join(known, ", "));
  }

  bool function(std::string_view word, std::size_t end) {
    if (word == "min" || word == "max") {
      at_ = end;
      extremum(word == "min" ? Kind::kMinimum : Kind::kMaximum);
      return true;
    }
    const FunctionRow* row = function_named(word == "tan" ? "sin" : word);
    if (word == "pi") {
      at_ = end;
      append(Kind::kNumber, std::numbers::pi);
      return true;
    }
    if (row == nullptr) return false;
    at_ = end;
    if (!take('(')) refuse("\"(\"");
    const std::size_t first = nodes_.size();
    sum();
    if (!take(')')) refuse("\")\"");
    const std::vector<Expression::Node> of(nodes_.begin() + static_cast<std::ptrdiff_t>(first), nodes_.end());
    append({.kind = Kind::kFunction, .function = row->function});
    if (word != "tan") return true;
    for (const Expression::Node& node : of) append(node);
    append({.kind = Kind::kFunction, .function = Function::kCosine});
    append(Kind::kQuotient);
    return true;
  }

  /// Parses the arguments of min or max, one or more.
  void extremum(Kind kind) {
    if (!take('(')) refuse("\"(\"");
    sum();
    while (take(',')) {
      sum();
      append(kind);
    }
    if (!take(')')) refuse("\",\" or \")\"");
  }

  double number(const char* expected) {
    skip_space();
    double value = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || !(std::abs(value) < kLargestFactor)) refuse(expected);
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }

  static constexpr double kLargestFactor = 1e15;
  std::string_view text_;
  const std::vector<std::string>& names_;
  bool functions_;
  std::size_t most_nodes_;
  std::vector<Expression::Node>& nodes_;
  std::size_t at_ = 0;
  int nested_ = 0;
};

Expression::Expression(std::string_view text, const std::vector<std::string>& names, Language language) {
  ExpressionParser(text, names, language, *this);
  finish();
  if (reads_.empty() && language == Language::kPolynomial)
    fail("expression \"{}\" has no name in it: expected a measured output or an input", text);
}

Expression::Expression(std::vector<Node> nodes) : nodes_(std::move(nodes)) {
  finish();
}

void Expression::finish() {
  for (const Node& node : nodes_)
    if (node.kind == Kind::kReading) reads_.push_back(node.reading);
  std::sort(reads_.begin(), reads_.end());
  reads_.erase(std::unique(reads_.begin(), reads_.end()), reads_.end());
}

std::string Expression::text(const std::function<std::string(int)>& reading,
                             const std::function<std::string(double)>& number,
                             const std::function<std::string(const std::string&)>& part_of_sum, bool is_part) const {
  struct Part {
    std::string text;
    Kind kind;
  };
  const auto summand = [&](const Part& part) {
    return part.kind == Kind::kProduct ? part_of_sum(part.text) : part.text;
  };
  const auto multiplies = [](Kind kind) { return kind == Kind::kProduct || kind == Kind::kQuotient; };
  const auto enclosed = [](const Part& part, bool always) {
    const bool sum = part.kind == Kind::kSum || part.kind == Kind::kDifference;
    return sum || always ? "(" + part.text + ")" : part.text;
  };
  // A quotient in a sum gets parentheses for readers (MISRA C 12.1).
  const auto term = [&](const Part& part) {
    return enclosed({summand(part), part.kind}, part.kind == Kind::kQuotient);
  };
  std::vector<Part> stack;
  for (const Node& node : nodes_) {
    if (node.kind == Kind::kNumber) {
      stack.push_back({number(node.number), node.kind});
    } else if (node.kind == Kind::kReading) {
      stack.push_back({reading(node.reading), node.kind});
    } else if (node.kind == Kind::kFunction) {
      stack.back() = {fmt::format("{}({})", row_of(node.function).runtime, summand(stack.back())), Kind::kReading};
    } else if (node.kind == Kind::kSquare) {
      const Part of = stack.back();
      stack.back() = {enclosed(of, false) + " * " + enclosed(of, multiplies(of.kind)), Kind::kProduct};
    } else {
      const Part right = stack.back();
      stack.pop_back();
      Part& left = stack.back();
      // Parentheses around the right operand keep the order of evaluation: it is evaluated first.
      if (node.kind == Kind::kMinimum || node.kind == Kind::kMaximum) {
        left = {fmt::format("{}({}, {})", node.kind == Kind::kMinimum ? "minimum" : "maximum", summand(left),
                            summand(right)),
                Kind::kReading};
        continue;
      }
      if (multiplies(node.kind))
        left.text = enclosed(left, false) + (node.kind == Kind::kProduct ? " * " : " / ") +
                    enclosed(right, multiplies(right.kind));
      else
        left.text = (left.kind == Kind::kQuotient ? term(left) : summand(left)) +
                    (node.kind == Kind::kSum ? " + " : " - ") + term(right);
      left.kind = node.kind;
    }
  }
  return is_part ? summand(stack.back()) : stack.back().text;
}

int Expression::operations() const {
  return static_cast<int>(std::count_if(nodes_.begin(), nodes_.end(), [](const Node& node) {
    return node.kind != Kind::kNumber && node.kind != Kind::kReading && node.kind != Kind::kFunction;
  }));
}

int Expression::functions() const {
  return static_cast<int>(std::ranges::count(nodes_, Kind::kFunction, &Node::kind));
}

Parity Expression::parity(const std::vector<Parity>& readings) const {
  return evaluate<WithParity>([&](int j) { return WithParity(readings[static_cast<std::size_t>(j)]); }).parity;
}

}  // namespace nlo::codegen
