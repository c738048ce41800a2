// SPDX-License-Identifier: MIT
#include "codegen/base/embedded_text.h"

#include <algorithm>
#include <stdexcept>

namespace nlo::codegen {

std::string_view embedded_text(std::string_view name) {
  const auto texts = embedded_texts();
  const auto found = std::find_if(texts.begin(), texts.end(), [&](const EmbeddedText& t) { return t.name == name; });
  if (found == texts.end()) throw std::logic_error("no text \"" + std::string(name) + "\" is embedded");
  return found->text;
}

std::string filled(std::string_view text, const std::map<std::string, std::string>& values) {
  constexpr std::string_view kKey = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  std::string result;
  for (;;) {
    const std::size_t at = text.find('@');
    result += text.substr(0, at);
    if (at == std::string_view::npos) return result;
    const std::size_t end = text.find_first_not_of(kKey, at + 1);
    if (end == std::string_view::npos || end == at + 1 || text[end] != '@') {  // a plain @
      result += '@';
      text.remove_prefix(at + 1);
      continue;
    }
    const std::string key(text.substr(at + 1, end - at - 1));
    const auto value = values.find(key);
    if (value == values.end()) throw std::logic_error("a template wants @" + key + "@, which has no value");
    result += value->second;
    text.remove_prefix(end + 1);
  }
}

}  // namespace nlo::codegen
