// SPDX-License-Identifier: MIT
#include "codegen/model/expression.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/ranges.h>

#include "codegen/base/fail.h"

namespace nlo::codegen {

Interval operator+(Interval a, Interval b) {
  return {a.low + b.low, a.high + b.high};
}
Interval operator-(Interval a, Interval b) {
  return {a.low - b.high, a.high - b.low};
}
Interval operator*(Interval a, Interval b) {
  const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
  return {low, high};
}

/// Descends through sums, products and powers, and appends what it meets in the order of evaluation.
class ExpressionParser {
 public:
  using Kind = Expression::Kind;

  ExpressionParser(std::string_view text, const std::vector<std::string>& names, Expression& result)
      : text_(text), names_(names), nodes_(result.nodes_) {
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
  void append(Kind kind, double number = 0.0, int reading = 0) {
    if (nodes_.size() == Expression::kMostNodes)
      fail("expression \"{}\" is too long: a computed output may have {} numbers, names and operations", text_,
           Expression::kMostNodes);
    nodes_.push_back({kind, number, reading});
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
      } else {
        const double divisor = number("a number other than 0: what is measured may be 0, and does not divide");
        if (divisor == 0.0) refuse("another number than 0 before this");
        append(Kind::kNumber, 1.0 / divisor);
      }
      append(Kind::kProduct);
    }
  }

  void factor() {
    const bool negative = take('-');
    const std::size_t first = nodes_.size();
    if (take('(')) {
      sum();
      if (!take(')')) refuse("\")\"");
    } else if (!at_end() && (std::isalpha(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_')) {
      append(Kind::kReading, 0.0, name());
    } else {
      append(Kind::kNumber, number("a number, the name of a measured output or input, or \"(\""));
    }
    if (take('^')) power(first);
    if (!negative) return;
    append(Kind::kNumber, -1.0);
    append(Kind::kProduct);
  }

  /// The nodes from `first` on, times themselves.
  void power(std::size_t first) {
    skip_space();
    const int power = at_ < text_.size() ? text_[at_] - '0' : 0;
    if (power < 1 || power > kMostPower) refuse("a whole power from 1 to 4");
    ++at_;
    const std::vector<Expression::Node> base(nodes_.begin() + static_cast<std::ptrdiff_t>(first), nodes_.end());
    for (int i = 1; i < power; ++i) {
      for (const Expression::Node& node : base) append(node.kind, node.number, node.reading);
      append(Kind::kProduct);
    }
  }

  int name() {
    std::size_t end = at_;
    while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) != 0 || text_[end] == '_'))
      ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    const auto found = std::find(names_.begin(), names_.end(), word);
    std::vector<std::string> known = names_;
    std::erase(known, "");  // in the place of what may not be read
    if (found == names_.end())
      fail("expression \"{}\" reads \"{}\": expected a measured output that does not wrap, or an input; there is {}",
           text_, word, fmt::join(known, ", "));
    at_ = end;
    return static_cast<int>(found - names_.begin());
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
  std::vector<Expression::Node>& nodes_;
  std::size_t at_ = 0;
  int nested_ = 0;
};

Expression::Expression(std::string_view text, const std::vector<std::string>& names) {
  ExpressionParser(text, names, *this);
  for (const Node& node : nodes_)
    if (node.kind == Kind::kReading) reads_.push_back(node.reading);
  std::sort(reads_.begin(), reads_.end());
  reads_.erase(std::unique(reads_.begin(), reads_.end()), reads_.end());
  if (reads_.empty())
    fail("expression \"{}\" reads nothing: expected the name of a measured output, or an input", text);
}

std::string Expression::text(const std::function<std::string(int)>& reading,
                             const std::function<std::string(double)>& number,
                             const std::function<std::string(const std::string&)>& part_of_sum) const {
  struct Part {
    std::string text;
    Kind kind;
  };
  const auto summand = [&](const Part& part) {
    return part.kind == Kind::kProduct ? part_of_sum(part.text) : part.text;
  };
  const auto enclosed = [](const Part& part, bool always) {
    const bool sum = part.kind == Kind::kSum || part.kind == Kind::kDifference;
    return sum || always ? "(" + part.text + ")" : part.text;
  };
  std::vector<Part> stack;
  for (const Node& node : nodes_) {
    if (node.kind == Kind::kNumber) {
      stack.push_back({number(node.number), node.kind});
    } else if (node.kind == Kind::kReading) {
      stack.push_back({reading(node.reading), node.kind});
    } else {
      const Part right = stack.back();
      stack.pop_back();
      Part& left = stack.back();
      // What stands on the right of an operator is evaluated first: that is what parentheses around it say.
      if (node.kind == Kind::kProduct)
        left.text = enclosed(left, false) + " * " + enclosed(right, right.kind == Kind::kProduct);
      else
        left.text = summand(left) + (node.kind == Kind::kSum ? " + " : " - ") +
                    (right.kind == Kind::kProduct ? summand(right) : enclosed(right, false));
      left.kind = node.kind;
    }
  }
  return stack.back().text;
}

int Expression::operations() const {
  return static_cast<int>(std::count_if(nodes_.begin(), nodes_.end(), [](const Node& node) {
    return node.kind != Kind::kNumber && node.kind != Kind::kReading;
  }));
}

namespace {

/// The parity of a sum and of a product.
struct WithParity {
  Parity parity;

  WithParity(double /*number*/ = 0.0) : parity(Parity::kEven) {}
  WithParity(Parity of_reading) : parity(of_reading) {}
};
WithParity operator+(WithParity a, WithParity b) {
  return a.parity == b.parity ? a : WithParity(Parity::kNeither);
}
WithParity operator-(WithParity a, WithParity b) {
  return a + b;
}
WithParity operator*(WithParity a, WithParity b) {
  if (a.parity == Parity::kNeither || b.parity == Parity::kNeither) return Parity::kNeither;
  return a.parity == b.parity ? Parity::kEven : Parity::kOdd;
}

}  // namespace

Parity Expression::parity(const std::vector<Parity>& readings) const {
  return evaluate<WithParity>([&](int j) { return WithParity(readings[static_cast<std::size_t>(j)]); }).parity;
}

}  // namespace nlo::codegen
