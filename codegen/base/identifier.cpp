// SPDX-License-Identifier: MIT
#include "codegen/base/identifier.h"

#include <algorithm>
#include <array>

namespace nlo::codegen {
namespace {

// Keywords and alternative tokens of C++20 and C, macros of the standard headers, and names that a generated header
// uses itself. Sorted.
constexpr std::array kReservedWords = {"EOF",          "Eigen",     "INFINITY",
                                       "Input",        "NAN",       "NULL",
                                       "Output",       "State",     "alignas",
                                       "alignof",      "and",       "and_eq",
                                       "asm",          "assert",    "auto",
                                       "bitand",       "bitor",     "bool",
                                       "break",        "case",      "catch",
                                       "char",         "char16_t",  "char32_t",
                                       "char8_t",      "class",     "co_await",
                                       "co_return",    "co_yield",  "codegen",
                                       "compl",        "concept",   "const",
                                       "const_cast",   "consteval", "constexpr",
                                       "constinit",    "continue",  "decltype",
                                       "default",      "delete",    "detail",
                                       "do",           "double",    "dynamic_cast",
                                       "else",         "enum",      "errno",
                                       "explicit",     "export",    "extern",
                                       "false",        "float",     "for",
                                       "friend",       "goto",      "if",
                                       "inline",       "int",       "kernels",
                                       "linux",        "long",      "mutable",
                                       "namespace",    "new",       "nlo",
                                       "noexcept",     "not",       "not_eq",
                                       "nullptr",      "operator",  "or",
                                       "or_eq",        "private",   "protected",
                                       "public",       "register",  "reinterpret_cast",
                                       "requires",     "restrict",  "return",
                                       "setjmp",       "short",     "signed",
                                       "sizeof",       "static",    "static_assert",
                                       "static_cast",  "std",       "stderr",
                                       "stdin",        "stdout",    "struct",
                                       "switch",       "template",  "this",
                                       "thread_local", "throw",     "trainer",
                                       "true",         "try",       "typedef",
                                       "typeid",       "typename",  "union",
                                       "unix",         "unsigned",  "using",
                                       "virtual",      "void",      "volatile",
                                       "wchar_t",      "while",     "xor",
                                       "xor_eq"};

}  // namespace

bool is_identifier(std::string_view text) {
  constexpr std::size_t kLongest = 63;  // C99 distinguishes 63 characters
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && text.size() <= kLongest && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is_letter(c) || is_digit(c) || c == '_'; }) &&
         text.find("__") == std::string_view::npos &&  // reserved to the compiler anywhere in a name
         std::find(kReservedWords.begin(), kReservedWords.end(), text) == kReservedWords.end();
}

}  // namespace nlo::codegen
