// SPDX-License-Identifier: MIT
#include "codegen/readback/token_stream.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "codegen/base/fail.h"

namespace nlo::codegen {
namespace {

bool opens(const Token& token) {
  return token.is("(") || token.is("[") || token.is("{");
}
bool closes(const Token& token) {
  return token.is(")") || token.is("]") || token.is("}");
}

/// expression = term {(+ | -) term}, term = factor {(* | /) factor}
class Integers {
 public:
  Integers(const std::vector<Token>& tokens, const std::map<std::string, long>& known)
      : tokens_(tokens), known_(known) {}

  std::optional<long> value() {
    const std::optional<long> sum = expression();
    return at_ == tokens_.size() ? sum : std::nullopt;
  }

 private:
  bool accept(std::string_view mark) {
    const bool found = at_ < tokens_.size() && tokens_[at_].is(mark);
    if (found) ++at_;
    return found;
  }
  std::optional<long> expression() {
    std::optional<long> sum = term();
    while (sum) {
      const bool plus = accept("+");
      if (!plus && !accept("-")) break;
      const std::optional<long> next = term();
      sum = next ? std::optional(plus ? *sum + *next : *sum - *next) : std::nullopt;
    }
    return sum;
  }
  std::optional<long> term() {
    std::optional<long> product = factor();
    while (product) {
      const bool times = accept("*");
      if (!times && !accept("/")) break;
      const std::optional<long> next = factor();
      if (!next || (!times && *next == 0)) return std::nullopt;
      product = times ? *product * *next : *product / *next;
    }
    return product;
  }
  std::optional<long> factor() {
    if (accept("-")) {
      const std::optional<long> value = factor();
      return value ? std::optional(-*value) : std::nullopt;
    }
    if (accept("(")) {
      const std::optional<long> value = expression();
      return accept(")") ? value : std::nullopt;
    }
    if (at_ == tokens_.size()) return std::nullopt;
    const Token& token = tokens_[at_++];
    if (const auto found = known_.find(token.text); found != known_.end()) return found->second;
    char* end = nullptr;
    const long value = std::strtol(token.text.c_str(), &end, 0);
    if (token.kind != Token::Kind::kNumber || (*end != '\0' && std::string_view(end) != "U")) return std::nullopt;
    return value;
  }

  const std::vector<Token>& tokens_;
  const std::map<std::string, long>& known_;
  std::size_t at_ = 0;
};

}  // namespace

Token TokenStream::take() {
  if (at_end()) fail("line {}: the text ends too early", line());
  return tokens_[at_++];
}

bool TokenStream::accept(std::string_view mark) {
  const bool found = at(mark);
  if (found) ++at_;
  return found;
}

void TokenStream::expect(std::string_view mark) {
  if (!accept(mark)) fail("line {}: \"{}\" where {} is missing", line(), at_end() ? "" : word(), mark);
}

std::vector<Token> TokenStream::take_until(std::initializer_list<std::string_view> marks) {
  std::vector<Token> taken;
  for (int depth = 0, angles = 0;;) {
    if (at_end()) fail("line {}: the text ends too early", line());
    const Token& token = tokens_[at_];
    const bool found = std::any_of(marks.begin(), marks.end(), [&](std::string_view mark) { return token.is(mark); });
    if (found && depth == 0 && angles <= 0) return taken;
    depth += opens(token) ? 1 : closes(token) ? -1 : 0;
    angles += token.is("<") ? 1 : token.is(">") ? -1 : 0;
    taken.push_back(token);
    ++at_;
  }
}

void TokenStream::skip_past(std::string_view mark) {
  while (!take().is(mark)) {
  }
}

void TokenStream::skip_balanced() {
  int depth = 0;
  do {
    const Token token = take();
    depth += opens(token) ? 1 : closes(token) ? -1 : 0;
  } while (depth > 0);
}

std::vector<std::vector<Token>> TokenStream::arguments_ahead() const {
  std::vector<std::vector<Token>> arguments(1);
  int depth = 0;
  for (std::size_t i = at_ + 1; i < tokens_.size(); ++i) {
    const Token& token = tokens_[i];
    if (closes(token) && --depth == 0) break;
    if (depth == 1 && token.is(",")) {
      arguments.emplace_back();
    } else if (depth > 0) {
      arguments.back().push_back(token);
    }
    if (opens(token)) ++depth;
  }
  return arguments;
}

bool is_qualifier(std::string_view word) {
  static constexpr std::array kWords = {"static", "inline", "const", "constexpr", "IN_FLASH", "volatile"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

bool has(const std::vector<Token>& tokens, std::string_view word) {
  return std::any_of(tokens.begin(), tokens.end(), [&](const Token& token) { return token.is(word); });
}

std::vector<Token> joined(std::vector<Token> first, const std::vector<Token>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::string text_of(const std::vector<Token>& tokens) {
  std::string text;
  for (const Token& token : tokens) text += token.text;
  return text;
}

std::string type_of(const std::vector<Token>& head) {
  std::string text;
  for (const Token& token : head)
    if (!is_qualifier(token.text)) text += token.text;
  return text;
}

std::optional<long> integer_of(const std::vector<Token>& expression, const std::map<std::string, long>& known) {
  return Integers(expression, known).value();
}

}  // namespace nlo::codegen
