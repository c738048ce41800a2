// SPDX-License-Identifier: MIT
#include "codegen/readback/tokens.h"

#include <algorithm>
#include <cctype>

namespace nlo::codegen {
namespace {

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}
bool of_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  std::vector<Token> all() {
    std::vector<Token> tokens;
    while (skip_what_says_nothing()) {
      const std::size_t start = at_;
      const Token::Kind kind = take();
      tokens.push_back({kind, std::string(text_.substr(start, at_ - start)), line_, start});
    }
    return tokens;
  }

 private:
  char next(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  void step() {
    if (next() == '\n') ++line_;
    ++at_;
  }
  void to_end_of_line() {
    while (at_ < text_.size() && next() != '\n') {
      if (next() == '\\') step();  // the line goes on
      if (at_ < text_.size()) step();
    }
  }

  /// False at the end of the text.
  bool skip_what_says_nothing() {
    for (; at_ < text_.size(); first_of_line_ = first_of_line_ || text_[at_ - 1] == '\n') {
      if (std::isspace(static_cast<unsigned char>(next())) != 0) {
        step();
      } else if ((next() == '/' && next(1) == '/') || (next() == '#' && first_of_line_)) {
        to_end_of_line();
      } else if (next() == '/' && next(1) == '*') {
        while (at_ < text_.size() && !(next() == '*' && next(1) == '/')) step();
        at_ = std::min(at_ + 2, text_.size());
      } else {
        first_of_line_ = false;
        return true;
      }
    }
    return false;
  }

  Token::Kind take() {
    const char first = next();
    if (is_digit(first) || (first == '.' && is_digit(next(1)))) {
      const bool hexadecimal = first == '0' && (next(1) == 'x' || next(1) == 'X');
      const auto before_sign = [&](char c) { return hexadecimal ? c == 'p' || c == 'P' : c == 'e' || c == 'E'; };
      while (of_word(next()) || next() == '.' || ((next() == '+' || next() == '-') && before_sign(text_[at_ - 1])))
        step();
      return Token::Kind::kNumber;
    }
    if (of_word(first)) {
      while (of_word(next()) || (next() == ':' && next(1) == ':' && of_word(next(2)))) at_ += next() == ':' ? 2 : 1;
      return Token::Kind::kWord;
    }
    step();
    if (first != '"' && first != '\'') return Token::Kind::kMark;
    while (at_ < text_.size() && next() != first) {
      if (next() == '\\') step();
      step();
    }
    at_ = std::min(at_ + 1, text_.size());
    return Token::Kind::kText;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  bool first_of_line_ = true;
};

}  // namespace

std::vector<Token> tokens_of(std::string_view text) {
  return Lexer(text).all();
}

}  // namespace nlo::codegen
