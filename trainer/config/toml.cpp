// SPDX-License-Identifier: MIT
#include "trainer/config/toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "codegen/base/error.h"
#include "trainer/base/trimmed.h"

namespace nlo::trainer {
namespace {

constexpr int kMaxDepth = 32;                     // nesting of brackets and braces
constexpr int kMaxDots = 16;                      // in one key
constexpr std::string_view kOverride = "--set ";  // stands for the file name of values from --set

[[noreturn]] void fail(const std::string& filename, std::size_t line, const std::string& what) {
  throw codegen::Error(fmt::format("{}:{}: {}", filename, line, what));
}

/// Returns the length of the UTF-8 sequence at `at`; 0 if there is none (overlong forms and surrogates are invalid).
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
  const unsigned b = byte(0);
  if (b < 0x80u) return 1;
  if (b >= 0xC2u && b <= 0xDFu) return follows(1) ? 2 : 0;
  if (b >= 0xE0u && b <= 0xEFu) {
    const bool overlong = b == 0xE0u && byte(1) < 0xA0u, surrogate = b == 0xEDu && byte(1) > 0x9Fu;
    return follows(1) && follows(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (b >= 0xF0u && b <= 0xF4u) {
    const bool overlong = b == 0xF0u && byte(1) < 0x90u, beyond = b == 0xF4u && byte(1) > 0x8Fu;
    return follows(1) && follows(2) && follows(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

/// Checks a text before the parser reads it. Skips TOML's strings and comments, so that brackets in them do not count.
class Guard {
 public:
  Guard(std::string_view text, const std::string& filename) : text_(text), filename_(filename) {}

  void check() {
    check_encoding();
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        skip_comment();
        continue;
      }
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '\n') ++line_;
      if (c == '[' || c == '{') ++depth_;
      if (c == ']' || c == '}') depth_ = std::max(0, depth_ - 1);
      if (c == '.') ++dots_;
      if (std::string_view(",[]{}=\n").find(c) != std::string_view::npos) dots_ = 0;
      if (depth_ > kMaxDepth)
        fail(filename_, line_, fmt::format("brackets are nested more than {} deep; an experiment needs 3", kMaxDepth));
      if (dots_ > kMaxDots)
        fail(filename_, line_, fmt::format("a key has more than {} dots; an experiment needs 2", kMaxDots));
      ++at_;
    }
  }

 private:
  void check_encoding() {
    std::size_t line = 1;
    for (std::size_t at = 0; at < text_.size();) {
      const std::size_t length = utf8_length(text_, at);
      const auto c = static_cast<unsigned char>(text_[at]);
      if (length == 0 || (c < 0x20 && c != '\n' && c != '\r' && c != '\t') || c == 0x7F)
        fail(filename_, line, fmt::format("byte 0x{:02X} is not text; an experiment is a TOML file in UTF-8", c));
      if (c == '\n') ++line;
      at += length;
    }
  }

  void skip_comment() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  void skip_string(char quote) {
    const std::string triple(3, quote);
    const bool multiline = text_.substr(at_, 3) == triple;
    at_ += multiline ? 3 : 1;
    while (at_ < text_.size()) {
      if (text_[at_] == '\n' && !multiline) return;  // never closed: the parser reports it
      if (text_[at_] == '\n') ++line_;
      if (multiline ? text_.substr(at_, 3) == triple : text_[at_] == quote) {
        at_ += multiline ? 3 : 1;
        return;
      }
      at_ += text_[at_] == '\\' && quote == '"' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n' ? 2 : 1;
    }
  }

  std::string_view text_;
  const std::string& filename_;
  std::size_t at_ = 0, line_ = 1;
  int depth_ = 0, dots_ = 0;
};

/// Returns the first line of a message of toml11 without the name of its function: "missing ..." of "[error]
/// toml::parse_array: missing ...\n --> file...". The caller writes FILE:LINE instead of the other lines.
std::string first_line(std::string message) {
  message = message.substr(0, message.find('\n'));
  for (const std::string_view prefix : {"[error] ", "toml::"})
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
  const auto colon = message.find(": ");
  if (colon != std::string::npos && message.find(' ') > colon) message.erase(0, colon + 2);
  return message;
}

constexpr std::string_view kWhiteSpace = " \t\r\n";

/// Returns line `number` of `text`, from 1, without its comment.
std::string_view line_of(std::string_view text, std::size_t number) {
  for (; number > 1 && text.find('\n') != std::string_view::npos; --number) text.remove_prefix(text.find('\n') + 1);
  text = text.substr(0, text.find('\n'));
  return trimmed(text.substr(0, text.find('#')), kWhiteSpace);
}

bool is_bare_word(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto fits = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || std::string_view("_:.-").find(c) != std::string_view::npos;
  };
  if (text.empty() || !is_letter(text.front()) || !std::all_of(text.begin(), text.end(), fits)) return false;
  return text != "true" && text != "false" && text != "inf" && text != "nan";
}

/// Adds the correct way to write the line that toml11 refuses with `message`.
std::string with_remedy(const std::string& message, std::string_view line) {
  if (line.starts_with('[')) {
    const bool is_list = line.starts_with("[[");
    const std::string_view inside = trimmed(line.substr(is_list ? 2 : 1)),
                           name = inside.substr(0, inside.find_first_of(" ]"));
    const std::string heading = is_list ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
    if (is_bare_word(name) && line != heading)
      return fmt::format("\"{}\" does not open a section: write {}", line, heading);
  }
  if (is_bare_word(line)) return fmt::format("\"{}\" has no value: write {} = VALUE, or [{}]", line, line, line);
  return line.empty() ? message : fmt::format("{}: {}", message, line);
}

}  // namespace

Toml parse_toml(std::string_view text, const std::string& filename) {
  if (text.size() > kMaxConfigBytes)
    throw codegen::Error(
        fmt::format("{}: {} bytes is too big for an experiment; the limit is 1 MB", filename, text.size()));
  Guard(text, filename).check();
  const std::string_view content = trimmed(text, kWhiteSpace);
  if (content.empty()) return Toml(Toml::table_type{});
  if (content.front() == '{')
    fail(filename, 1,
         "this is JSON, such as a model.json; an experiment is a TOML file. nlo evaluate and nlo export read models");
  std::istringstream stream{std::string(text)};
  try {
    return toml::parse<toml::discard_comments, std::map, std::vector>(stream, filename);
  } catch (const toml::exception& error) {
    const std::size_t line = error.location().line();
    fail(filename, line, with_remedy(first_line(error.what()), line_of(text, line)));
  } catch (const std::exception& error) {  // toml11 passes some exceptions of the standard library
    throw codegen::Error(fmt::format("{}: {}", filename, first_line(error.what())));
  }
}

void apply_override(Toml& root, const std::string& assignment) {
  const std::string origin = std::string(kOverride) + assignment;
  const auto complain = [&](const std::string& what) { throw codegen::Error(fmt::format("{}: {}", origin, what)); };
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) complain("no KEY=VALUE; write for example --set training.steps=2000");
  const std::string key = assignment.substr(0, equals);
  std::string value = assignment.substr(equals + 1);
  if (value.find('\n') != std::string::npos) complain("the value has more than one line; give one");
  if (is_bare_word(value)) value = toml_text(value);

  std::vector<std::string> path;
  std::istringstream parts(key);
  for (std::string part; std::getline(parts, part, '.');) path.push_back(part);
  if (key.back() == '.' || path.size() > 3 || std::find(path.begin(), path.end(), "") != path.end())
    complain("the key is not SECTION.KEY; write for example --set training.steps=2000");

  Toml parsed;
  try {
    parsed = parse_toml("value = " + value, origin);
  } catch (const codegen::Error& error) {
    std::string message = error.what();  // "--set k=v:1: what": an override has no line numbers
    if (message.starts_with(origin + ":"))
      message.erase(origin.size(), message.find(": ", origin.size()) - origin.size());
    throw codegen::Error(message + " (values are TOML: numbers, true, [lists], \"text\")");
  }
  if (parsed.as_table().size() != 1) complain("the value is followed by something else; give one value");

  Toml* table = &root;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    Toml& next = table->as_table()[path[i]];
    if (next.is_uninitialized()) next = Toml(Toml::table_type{});
    if (!next.is_table()) complain(fmt::format("\"{}\" is not a section whose keys can be set", path[i]));
    table = &next;
  }
  table->as_table()[path.back()] = parsed.as_table().begin()->second;
}

std::string place_of(const Toml& value) {
  const auto location = value.location();
  const std::string& file = location.file_name();
  return file.starts_with(kOverride) ? file : fmt::format("{}:{}", file, location.line());
}

std::vector<std::pair<std::string, const Toml*>> members_in_order(const Toml& table) {
  struct Member {
    bool overridden;
    std::size_t line, column;
    std::string name;
    const Toml* value;
  };
  std::vector<Member> members;
  for (const auto& [name, value] : table.as_table()) {
    const auto location = value.location();
    members.push_back({location.file_name().starts_with(kOverride), location.line(), location.column(), name, &value});
  }
  std::stable_sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
    return std::tie(a.overridden, a.line, a.column) < std::tie(b.overridden, b.line, b.column);
  });
  std::vector<std::pair<std::string, const Toml*>> result;
  for (const Member& member : members) result.emplace_back(member.name, member.value);
  return result;
}

std::string_view type_in_words(const Toml& value) {
  switch (value.type()) {
    case toml::value_t::boolean:
      return "true or false";
    case toml::value_t::integer:
      return "an integer";
    case toml::value_t::floating:
      return "a number";
    case toml::value_t::string:
      return "a string";
    case toml::value_t::array:
      return "a list";
    case toml::value_t::table:
      return "a table";
    case toml::value_t::empty:
      return "nothing";
    default:
      return "a date or time";
  }
}

std::string toml_text(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      result += c;
    }
  }
  return result + '"';
}

}  // namespace nlo::trainer
