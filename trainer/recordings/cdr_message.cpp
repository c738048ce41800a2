// SPDX-License-Identifier: MIT
#include "trainer/recordings/cdr_message.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

constexpr int kDeepest = 32;  // messages within messages: a definition may contain itself

std::size_t size_of(FieldKind kind) {
  switch (kind) {
    case FieldKind::kBool:
    case FieldKind::kInt8:
    case FieldKind::kUint8:
      return 1;
    case FieldKind::kInt16:
    case FieldKind::kUint16:
      return 2;
    case FieldKind::kInt32:
    case FieldKind::kUint32:
    case FieldKind::kFloat32:
      return 4;
    default:
      return 8;
  }
}

class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {
    if (bytes.size() < 4) throw Error("is too short for a message");
    if (bytes.starts_with("\x28\xB5\x2F\xFD"))
      throw Error("is compressed: ros2 bag convert writes it without compression");
    if (bytes[0] != 0 || (bytes[1] != 0 && bytes[1] != 1)) throw Error("is not plain CDR");
    swap_ = (bytes[1] == 1) != (std::endian::native == std::endian::little);
  }

  /// Aligned as one of `size` bytes, counted from behind the first four.
  const char* take(std::size_t size, std::size_t count = 1) {
    const std::size_t from = 4 + (at_ - 4 + size - 1) / size * size;
    if (from > bytes_.size() || count > (bytes_.size() - from) / size)
      throw Error(fmt::format("ends after {} bytes, within a field", bytes_.size()));
    at_ = from + size * count;
    return bytes_.data() + from;
  }

  template <class T>
  T number() {
    T value;
    char copy[sizeof(T)];
    std::memcpy(copy, take(sizeof(T)), sizeof(T));
    if (swap_) std::reverse(copy, copy + sizeof(T));
    std::memcpy(&value, copy, sizeof(T));
    return value;
  }

  double number(FieldKind kind) {
    switch (kind) {
      case FieldKind::kBool:
      case FieldKind::kUint8:
        return number<std::uint8_t>();
      case FieldKind::kInt8:
        return number<std::int8_t>();
      case FieldKind::kInt16:
        return number<std::int16_t>();
      case FieldKind::kUint16:
        return number<std::uint16_t>();
      case FieldKind::kInt32:
        return number<std::int32_t>();
      case FieldKind::kUint32:
        return number<std::uint32_t>();
      case FieldKind::kInt64:
        return static_cast<double>(number<std::int64_t>());
      case FieldKind::kUint64:
        return static_cast<double>(number<std::uint64_t>());
      case FieldKind::kFloat32:
        return static_cast<double>(number<float>());
      default:
        return number<double>();
    }
  }

  std::string_view text(FieldKind kind) {
    const auto length = number<std::uint32_t>();
    if (length == 0) return {};
    if (kind == FieldKind::kWideString) return take(4, length), std::string_view();
    const std::string_view all(take(1, length), length);
    return all.substr(0, all.find('\0'));
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 4;
  bool swap_ = false;
};

bool is_text(FieldKind kind) {
  return kind == FieldKind::kString || kind == FieldKind::kWideString;
}

bool is_time_type(const MessageField& field) {
  return field.type == "builtin_interfaces/Time" || field.type == "builtin_interfaces/Duration";
}

const MessageType& message_of(const MessageField& field) {
  if (field.message == nullptr) throw Error(fmt::format("has a {}, whose definition the bag has not", field.type));
  return *field.message;
}

/// Walks over a message; `wanted` are the values that lie in it, from their step `depth` on.
class Walk {
 public:
  explicit Walk(Cursor& cursor) : cursor_(cursor) {}

  void message(const MessageType& type, const std::vector<MessageValue*>& wanted, std::size_t depth) {
    if (depth > kDeepest) throw Error(fmt::format("has messages within messages, {} deep", kDeepest));
    std::vector<std::string> names;  // of elements, as a JointState has them
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const MessageField& field = type.fields[i];
      std::vector<MessageValue*> here;
      for (MessageValue* value : wanted)
        if (depth < value->steps.size() && value->steps[depth].field == i) here.push_back(value);
      if (!field.is_array) {
        one(field, here, depth);
        continue;
      }
      const std::size_t length = field.length > 0 ? field.length : cursor_.number<std::uint32_t>();
      if (field.kind != FieldKind::kMessage && !is_text(field.kind) && here.empty()) {
        if (length > 0) cursor_.take(size_of(field.kind), length);
        continue;
      }
      for (MessageValue* value : here) find_element(*value, depth, names);
      for (std::size_t e = 0; e < length; ++e) {
        std::vector<MessageValue*> of_element;
        for (MessageValue* value : here)
          if (value->steps[depth].index == e) of_element.push_back(value);
        if (field.name == "name" && field.kind == FieldKind::kString)
          names.emplace_back(cursor_.text(field.kind));
        else
          one(field, of_element, depth);
      }
    }
    if (type.fields.empty()) cursor_.take(1);  // an empty struct has one byte
  }

 private:
  void one(const MessageField& field, const std::vector<MessageValue*>& wanted, std::size_t depth) {
    if (field.kind == FieldKind::kMessage) {
      const MessageType& type = message_of(field);
      if (is_time_type(field)) {
        const auto seconds = cursor_.number<std::int32_t>();
        const auto rest = cursor_.number<std::uint32_t>();
        for (MessageValue* value : wanted) {
          value->nanoseconds = std::int64_t{1000000000} * seconds + rest;
          const bool whole = value->is_time, first = !whole && value->steps.back().field == 0;
          value->value = whole ? 1e-9 * static_cast<double>(value->nanoseconds) : first ? seconds : rest;
        }
        return;
      }
      message(type, wanted, depth + 1);
      return;
    }
    if (is_text(field.kind)) {
      cursor_.text(field.kind);
      return;
    }
    const double number = cursor_.number(field.kind);
    for (MessageValue* value : wanted) value->value = number;
  }

  static void find_element(MessageValue& value, std::size_t depth, const std::vector<std::string>& names) {
    MessageValue::Step& step = value.steps[depth];
    if (step.name.empty()) return;
    step.index = static_cast<std::size_t>(std::find(names.begin(), names.end(), step.name) - names.begin());
    if (step.index == names.size()) step.index = std::numeric_limits<std::size_t>::max();  // not in this message
  }

  Cursor& cursor_;
};

/// Numbers of `type`, with the lengths that this message has.
void collect(const MessageType& type, Cursor& cursor, const std::string& above, bool keep, int depth,
             std::vector<std::string>& paths) {
  constexpr std::size_t kLongest = 32;
  if (depth > kDeepest) throw Error("has messages within messages without an end");
  for (const MessageField& field : type.fields) {
    const std::size_t length = !field.is_array ? 1 : field.length > 0 ? field.length : cursor.number<std::uint32_t>();
    const bool kept = keep && field.type != "std_msgs/Header" && !is_time_type(field) && length <= kLongest &&
                      !field.name.ends_with("covariance") && !(field.is_array && field.kind == FieldKind::kMessage);
    for (std::size_t e = 0; e < length; ++e) {
      const std::string path = above + field.name + (field.is_array ? fmt::format("[{}]", e) : "");
      if (field.kind == FieldKind::kMessage)
        collect(message_of(field), cursor, path + ".", kept, depth + 1, paths);
      else if (is_text(field.kind))
        cursor.text(field.kind);
      else {
        cursor.number(field.kind);
        if (kept) paths.push_back(path);
      }
    }
  }
  if (type.fields.empty()) cursor.take(1);
}

}  // namespace

MessageValue::MessageValue(const MessageType& of, std::string_view path) {
  const MessageType* type = &of;
  const std::string whole = ascii(path);
  while (true) {
    const std::size_t end = std::min(path.find_first_of(".["), path.size());
    const MessageField* field = type->field(path.substr(0, end));
    if (field == nullptr) {
      const std::vector<std::string> known = type->field_names();
      const std::string nearest = nearest_name(path.substr(0, end), known);
      throw Error(fmt::format("{} has no \"{}\", it has {}{}", type->name, ascii(path.substr(0, end)),
                              fmt::join(known, ", "),
                              nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
    }
    Step step;
    step.field = static_cast<std::size_t>(field - type->fields.data());
    path.remove_prefix(end);
    if (path.starts_with('[')) {
      const std::size_t close = std::min(path.find(']'), path.size());
      const std::string_view index = path.substr(1, close - 1);
      step.is_indexed = true;
      if (std::from_chars(index.data(), index.data() + index.size(), step.index).ptr != index.data() + index.size() ||
          index.empty())
        step.name = std::string(index);
      path.remove_prefix(std::min(close + 1, path.size()));
    }
    if (step.is_indexed != field->is_array)
      throw Error(field->is_array
                      ? fmt::format("{} is an array: write {}[0], or {}[NAME] where the message has names", whole,
                                    field->name, field->name)
                      : fmt::format("{} is not an array: write {} without [...]", field->name, field->name));
    if (!step.name.empty() && type->field("name") == nullptr)
      throw Error(
          fmt::format("{}[{}]: {} has no array \"name\": write a number, from 0", field->name, step.name, type->name));
    steps.push_back(step);
    if (path.starts_with('.')) path.remove_prefix(1);
    if (field->kind == FieldKind::kMessage && path.empty() && is_time_type(*field)) {
      is_time = true;
      return;
    }
    if (is_text(field->kind)) throw Error(fmt::format("{} is text: expected a number", whole));
    if (field->kind != FieldKind::kMessage) {
      if (!path.empty()) throw Error(fmt::format("{} is a {}, it has no fields", field->name, field->type));
      return;
    }
    if (path.empty())
      throw Error(fmt::format("{} is a {}: name one of its fields, {}", whole, field->type,
                              fmt::join(message_of(*field).field_names(), ", ")));
    type = &message_of(*field);
  }
}

void read_message(const MessageType& type, std::string_view bytes, std::vector<MessageValue>& values) {
  std::vector<MessageValue*> all;
  for (MessageValue& value : values) {
    value.value = std::numeric_limits<double>::quiet_NaN();
    all.push_back(&value);
  }
  Cursor cursor(bytes);
  Walk(cursor).message(type, all, 0);
}

std::vector<std::string> numbers_in(const MessageType& type, std::string_view bytes) {
  std::vector<std::string> paths;
  Cursor cursor(bytes);
  collect(type, cursor, "", true, 0, paths);
  return paths;
}

}  // namespace nlo::trainer
