// SPDX-License-Identifier: MIT
#include "trainer/recordings/message_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

constexpr auto kPrimitives = std::to_array<std::pair<std::string_view, FieldKind>>({
    {"bool", FieldKind::kBool},
    {"byte", FieldKind::kUint8},
    {"char", FieldKind::kUint8},
    {"int8", FieldKind::kInt8},
    {"uint8", FieldKind::kUint8},
    {"int16", FieldKind::kInt16},
    {"uint16", FieldKind::kUint16},
    {"int32", FieldKind::kInt32},
    {"uint32", FieldKind::kUint32},
    {"int64", FieldKind::kInt64},
    {"uint64", FieldKind::kUint64},
    {"float32", FieldKind::kFloat32},
    {"float64", FieldKind::kFloat64},
    {"string", FieldKind::kString},
    {"wstring", FieldKind::kWideString},
});

/// "sensor_msgs/msg/Imu" as "sensor_msgs/Imu".
std::string plain_name(std::string name) {
  if (const std::size_t at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

std::string_view first_word(std::string_view& line) {
  const std::size_t from = std::min(line.find_first_not_of(" \t\r"), line.size());
  const std::size_t end = std::min(line.find_first_of(" \t\r", from), line.size());
  const std::string_view word = line.substr(from, end - from);
  line.remove_prefix(end);
  return word;
}

/// Adds the field of a line; a comment, a constant or nothing adds none.
void add_field(std::string_view line, const std::string& package, MessageType& type) {
  const std::string_view whole = line;
  line = line.substr(0, line.find('#'));
  std::string_view of = first_word(line);
  if (of.empty()) return;
  std::string_view name = first_word(line);
  const std::string_view behind = first_word(line);
  if (name.find('=') != std::string_view::npos || behind.starts_with('=')) return;  // a constant
  MessageField field;
  field.name = std::string(name);
  if (const std::size_t open = of.find('['); open != std::string_view::npos) {
    const std::string_view length = of.substr(open + 1, of.find(']', open) - open - 1);
    field.is_array = true;
    const bool bounded = length.empty() || length.starts_with("<=");
    if (!bounded && (std::from_chars(length.data(), length.data() + length.size(), field.length).ec != std::errc() ||
                     field.length == 0))
      name = {};
    of = of.substr(0, open);
  }
  of = of.substr(0, of.find("<="));
  if (name.empty() || of.empty())
    throw codegen::Error(
        fmt::format("the definition of {} has a line that is not a field: \"{}\"", type.name, ascii(whole)));
  const auto primitive = std::ranges::find(kPrimitives, of, [](const auto& p) { return p.first; });
  field.type = plain_name(std::string(of));
  if (primitive != kPrimitives.end()) field.kind = primitive->second;
  if (primitive == kPrimitives.end() && field.type == "Header") field.type = "std_msgs/Header";
  if (primitive == kPrimitives.end() && field.type.find('/') == std::string::npos)
    field.type = package + "/" + field.type;
  type.fields.push_back(std::move(field));
}

}  // namespace

const MessageField* MessageType::field(std::string_view wanted) const {
  const auto found = std::ranges::find(fields, wanted, [](const MessageField& f) { return std::string_view(f.name); });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<std::string> MessageType::field_names() const {
  std::vector<std::string> names;
  for (const MessageField& known : fields) names.push_back(known.name);
  return names;
}

MessageTypes::MessageTypes() {
  define("", built_in_messages());
}

void MessageTypes::define(const std::string& name, std::string_view text) {
  MessageType type;
  type.name = plain_name(name);
  const auto keep = [&] {
    if (!type.name.empty()) types_[type.name] = std::move(type);
    type = {};
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with("====")) continue;
    if (line.starts_with("MSG:")) {
      keep();
      std::string_view rest = line.substr(4);
      type.name = plain_name(std::string(first_word(rest)));
    } else if (!type.name.empty()) {
      add_field(line, type.name.substr(0, type.name.find('/')), type);
    }
  }
  keep();
  linked_ = false;
}

const MessageType* MessageTypes::find(const std::string& name) {
  if (!linked_) link();
  const auto found = types_.find(plain_name(name));
  return found == types_.end() ? nullptr : &found->second;
}

void MessageTypes::link() {
  for (auto& [name, type] : types_)
    for (MessageField& field : type.fields) {
      const auto found = types_.find(field.type);
      field.message = field.kind == FieldKind::kMessage && found != types_.end() ? &found->second : nullptr;
    }
  linked_ = true;
}

}  // namespace nlo::trainer
