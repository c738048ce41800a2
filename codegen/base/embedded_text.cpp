// SPDX-License-Identifier: MIT
#include "codegen/base/embedded_text.h"

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <vector>

namespace nlo::codegen {
namespace {

using Values = std::map<std::string, std::string>;

const std::string& value_of(std::string_view key, const Values& values) {
  const auto value = values.find(std::string(key));
  if (value == values.end()) throw std::logic_error("a template wants @" + std::string(key) + "@, which has no value");
  return value->second;
}

/// Returns the lines that `@if KEY@`, `@else@` and `@end@` select.
std::string lines_kept(std::string_view text, const Values& values) {
  constexpr std::string_view kIf = "@if ";
  std::string result;
  std::vector<bool> open;  // for each open section: true if its lines are kept
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, end), word = line.substr(0, line.find('\n'));
    text.remove_prefix(end);
    if (word.starts_with(kIf)) {
      open.push_back(!value_of(word.substr(kIf.size(), word.size() - kIf.size() - 1), values).empty());
    } else if (word != "@else@" && word != "@end@") {
      if (std::ranges::all_of(open, std::identity{})) result += line;
    } else if (open.empty()) {
      throw std::logic_error("a template has " + std::string(word) + " without @if@");
    } else if (word == "@else@") {
      open.back() = !open.back();
    } else {
      open.pop_back();
    }
  }
  if (!open.empty()) throw std::logic_error("a template has @if@ without @end@");
  return result;
}

}  // namespace

std::string_view embedded_text(std::string_view name) {
  const auto texts = embedded_texts();
  const auto found = std::find_if(texts.begin(), texts.end(), [&](const EmbeddedText& t) { return t.name == name; });
  if (found == texts.end()) throw std::logic_error("no text \"" + std::string(name) + "\" is embedded");
  return found->text;
}

std::string filled(std::string_view given, const Values& values) {
  constexpr std::string_view kKey = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  const std::string kept = lines_kept(given, values);
  std::string_view text = kept;
  std::string result;
  for (;;) {
    const std::size_t at = text.find('@');
    result += text.substr(0, at);
    if (at == std::string_view::npos) return result;
    const std::size_t end = text.find_first_not_of(kKey, at + 1);
    if (end == std::string_view::npos || end == at + 1 || text[end] != '@') {  // not a key: an @ of the text
      result += '@';
      text.remove_prefix(at + 1);
      continue;
    }
    result += value_of(text.substr(at + 1, end - at - 1), values);
    text.remove_prefix(end + 1);
  }
}

}  // namespace nlo::codegen
