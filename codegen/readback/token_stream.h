// SPDX-License-Identifier: MIT
// Tokens one after the other, for who reads declarations.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/readback/tokens.h"

namespace nlo::codegen {

/// Each function throws Error, naming the line, when the text ends where it goes on reading.
class TokenStream {
 public:
  explicit TokenStream(std::vector<Token> tokens) : tokens_(std::move(tokens)) {}

  bool at_end() const { return at_ == tokens_.size(); }
  int line() const { return tokens_.empty() ? 1 : tokens_[std::min(at_, tokens_.size() - 1)].line; }
  bool at(std::string_view mark, std::size_t ahead = 0) const {
    return at_ + ahead < tokens_.size() && tokens_[at_ + ahead].is(mark);
  }
  bool is_word() const { return !at_end() && tokens_[at_].kind == Token::Kind::kWord; }
  const std::string& word() const { return tokens_[at_].text; }
  std::size_t place() const { return tokens_[at_].at; }

  Token take();
  bool accept(std::string_view mark);
  void expect(std::string_view mark);

  /// Up to the first of `marks` that is in no bracket; it is not taken.
  std::vector<Token> take_until(std::initializer_list<std::string_view> marks);
  /// The words that a declaration begins with: up to what follows the declared name.
  std::vector<Token> take_head() { return take_until({"=", ";", "{", "(", "[", ","}); }
  void skip_past(std::string_view mark);
  void skip_balanced();  ///< from an opening bracket behind the closing one

  /// At a name before a parenthesis: the arguments, none of which is taken.
  std::vector<std::vector<Token>> arguments_ahead() const;

 private:
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
};

/// What does not say which type is declared.
bool is_qualifier(std::string_view word);

bool has(const std::vector<Token>& tokens, std::string_view word);
std::vector<Token> joined(std::vector<Token> first, const std::vector<Token>& second);
std::string text_of(const std::vector<Token>& tokens);  ///< without spaces
std::string type_of(const std::vector<Token>& head);    ///< its words without qualifiers

/// Sums and products of integers and of what `known` has.
std::optional<long> integer_of(const std::vector<Token>& expression, const std::map<std::string, long>& known);

}  // namespace nlo::codegen
