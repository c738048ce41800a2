// SPDX-License-Identifier: MIT
#include "trainer/config/value.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "codegen/base/error.h"
#include "codegen/base/identifier.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

constexpr double kTurnRad = 2.0 * std::numbers::pi;

std::string shown(const Toml& value) {
  constexpr std::size_t kLongest = 60;
  switch (value.type()) {
    case toml::value_t::boolean:
      return value.as_boolean() ? "true" : "false";
    case toml::value_t::integer:
      return std::to_string(value.as_integer());
    case toml::value_t::floating:
      return shortest_text(value.as_floating());
    case toml::value_t::string: {
      const std::string& text = value.as_string().str;
      return text.size() <= kLongest ? toml_text(text) : "a text of " + std::to_string(text.size()) + " bytes";
    }
    default:
      return std::string(type_in_words(value));
  }
}

[[noreturn]] void fail(const Toml& value, const std::string& where, const std::string& must) {
  throw codegen::Error(fmt::format("{}: {} is {}; {}", place_of(value), where, shown(value), must));
}

bool within(double x, const Rule& rule) {
  return (rule.low_is_open ? x > rule.low : x >= rule.low) && (rule.high_is_open ? x < rule.high : x <= rule.high);
}

std::string must_be(std::string_view type, const Rule& rule) {
  const std::string words = rule.in_words();
  return words.empty() ? fmt::format("it must be {}", type) : fmt::format("it must be {} {}", type, words);
}

/// Reads an integer. toml11 reads an integer that is too large as the largest one.
std::int64_t whole_number(const Toml& value, const std::string& where) {
  const std::int64_t number = value.as_integer();
  if (number == std::numeric_limits<std::int64_t>::max() || number == std::numeric_limits<std::int64_t>::min())
    throw codegen::Error(
        fmt::format("{}: {} has too many digits for an integer; write a smaller one", place_of(value), where));
  return number;
}

std::int64_t integer(const Toml& value, const std::string& where, const Rule& rule) {
  if (!value.is_integer()) fail(value, where, must_be("an integer", rule));
  const std::int64_t number = whole_number(value, where);
  if (!within(static_cast<double>(number), rule)) fail(value, where, must_be("an integer", rule));
  return number;
}

}  // namespace

std::string Rule::in_words() const {
  if (identifier) return "that is an identifier";
  if (!one_of.empty()) return fmt::format("out of \"{}\"", fmt::join(one_of, "\", \""));
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (has_low && has_high)
    return fmt::format("from {}{} to {}{}", shortest_text(low), low_is_open ? " (excluded)" : "", shortest_text(high),
                       high_is_open ? " (excluded)" : "");
  if (has_low) return fmt::format("{} {}", low_is_open ? ">" : ">=", shortest_text(low));
  if (has_high) return fmt::format("{} {}", high_is_open ? "<" : "<=", shortest_text(high));
  return "";
}

void read_value(const Toml& value, const std::string& where, const Rule&, bool& field) {
  if (!value.is_boolean()) fail(value, where, "it must be true or false");
  field = value.as_boolean();
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, int& field) {
  const std::int64_t number = integer(value, where, rule);
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
    fail(value, where, must_be("an integer of at most 9 digits", rule));
  field = static_cast<int>(number);
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, unsigned long long& field) {
  const std::int64_t number = integer(value, where, rule);
  if (number < 0) fail(value, where, "it must be an integer >= 0");
  field = static_cast<unsigned long long>(number);
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, double& field) {
  if (!value.is_integer() && !value.is_floating()) fail(value, where, must_be("a number", rule));
  const double number = value.is_integer() ? static_cast<double>(whole_number(value, where)) : value.as_floating();
  // toml11 reads 1e999 as the largest double.
  const bool is_finite = std::abs(number) < std::numeric_limits<double>::max();
  if (!is_finite || !within(number, rule)) fail(value, where, must_be("a finite number", rule));
  field = number;
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, std::string& field) {
  if (!value.is_string()) fail(value, where, must_be("a text in quotes", rule));
  const std::string& text = value.as_string().str;
  const bool has_control =
      std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (has_control) fail(value, where, "it must be one line without control characters");
  if (!rule.one_of.empty() && std::find(rule.one_of.begin(), rule.one_of.end(), text) == rule.one_of.end()) {
    const std::string nearest = nearest_name(text, rule.one_of);
    fail(value, where,
         fmt::format("use {}\"{}\"", nearest.empty() ? "" : fmt::format("\"{}\"? There are ", nearest),
                     fmt::join(rule.one_of, "\", \"")));
  }
  if (rule.identifier && !codegen::is_identifier(text))
    fail(value, where,
         "it must be an identifier: a letter, then letters, digits and single underscores (63 at most), no C++ word");
  field = text;
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, NoiseConfig& field) {
  if (value.is_array()) {
    NoiseConfig all;
    all.sensors.clear();
    for (const Toml& element : list_of(value, where, rule)) {
      const std::string index = fmt::format("{}[{}]", where, all.sensors.size());
      NoiseConfig one;
      if (element.is_array()) fail(element, index, "it must be the noise of one output");
      read_value(element, index, rule, one);
      if (one.sensors.size() != 1) fail(element, index, "it must be the noise of one output");
      all.sensors.push_back(one.sensors.front());
    }
    if (all.sensors.empty()) fail(value, where, "it must have one noise for each output; or write \"none\"");
    field = std::move(all);
    return;
  }
  if (!value.is_string())
    fail(value, where,
         "it must be \"none\", \"gaussian:SIGMA\", \"uniform:HALF_WIDTH\" or \"student:SCALE:FREEDOM\", or a list of "
         "these");
  try {
    field = parse_noise(value.as_string().str);
  } catch (const codegen::Error& error) {
    throw codegen::Error(fmt::format("{}: {}: {}", place_of(value), where, error.what()));
  }
}

void read_value(const Toml& value, const std::string& where, const Rule& rule, std::array<double, 2>& field) {
  const Toml::array_type& list = list_of(value, where, rule);
  if (list.size() != 2) fail(value, where, "it must be [re, im]");
  for (std::size_t i = 0; i < 2; ++i) read_value(list[i], where + (i == 0 ? "[re]" : "[im]"), rule, field[i]);
}

void read_parameters(const Toml& value, const std::string& where, std::vector<std::pair<std::string, double>>& values,
                     std::vector<std::pair<std::string, std::array<double, 2>>>& ranges) {
  if (!value.is_table()) fail(value, where, "it must be a table { NAME = number, ... }");
  values.clear();
  ranges.clear();
  for (const auto& [name, member] : members_in_order(value)) {
    if (!codegen::is_identifier(name))
      throw codegen::Error(
          fmt::format("{}: {} has the name {}; it must be an identifier", place_of(*member), where, toml_text(name)));
    const std::string at = where + "." + name;
    if (!member->is_array()) {
      read_value(*member, at, any(), values.emplace_back(name, 0.0).second);
      continue;
    }
    std::vector<double> ends;
    read_value(*member, at, any(), ends);
    if (ends.size() != 2) fail(*member, at, fmt::format("it has {} numbers, and a range is [low, high]", ends.size()));
    if (!(ends[0] <= ends[1]))
      fail(*member, at,
           fmt::format("its low end {} must not be above its high end {}", shortest_text(ends[0]),
                       shortest_text(ends[1])));
    values.emplace_back(name, 0.5 * ends[0] + 0.5 * ends[1]);
    ranges.push_back({name, {ends[0], ends[1]}});
  }
}

void read_value(const Toml& value, const std::string& where, const Rule&, EvaluationWindow& field) {
  if (!value.is_table()) fail(value, where, "it must be a table { name = TEXT, from_s = number, to_s = number }");
  EvaluationWindow window;
  for (const auto& [name, member] : members_in_order(value)) {
    const std::string at = where + "." + name;
    if (name == "name") {
      read_value(*member, at, identifiers(), window.name);
    } else if (name == "from_s") {
      read_value(*member, at, at_least(0.0), window.from_s);
    } else if (name == "to_s") {
      read_value(*member, at, positive(), window.to_s);
    } else {
      throw codegen::Error(fmt::format("{}: unknown key {} in {}; there are: name, from_s, to_s", place_of(*member),
                                       toml_text(name), where));
    }
  }
  if (window.name.empty()) fail(value, where, "it has no name; give one: { name = \"settled\", from_s = 2.0 }");
  field = window;
}

std::string show_wrap(double wrap) {
  return std::abs(wrap - kTurnRad) < 1e-12 ? "\"2pi\"" : shortest_text(wrap);
}

void read_wrap(const Toml& value, const std::string& where, double& field) {
  if (value.is_string() && value.as_string().str == "2pi") {
    field = kTurnRad;
  } else if (value.is_string() && value.as_string().str == "360deg") {
    field = 360.0;
  } else if (value.is_string()) {
    fail(value, where, "it must be a number (a full turn in the column's unit), \"2pi\" or \"360deg\"");
  } else {
    read_value(value, where, at_least(0.0), field);
  }
}

void read_delay(const Toml& value, const std::string& where, double& delay_s, bool& find) {
  find = value.is_string() && value.as_string().str == "estimate";
  if (find) {
    delay_s = 0.0;
  } else if (value.is_string()) {
    fail(value, where, "it must be a number of seconds, or \"estimate\" to find it in the training logs");
  } else {
    read_value(value, where, at_least(0.0), delay_s);
  }
}

void read_wraps(const Toml& value, const std::string& where, std::vector<double>& field) {
  std::vector<double> result;
  for (const Toml& element : list_of(value, where, any())) {
    const std::string index = fmt::format("{}[{}]", where, result.size());
    read_wrap(element, index, result.emplace_back());
  }
  field = std::move(result);
}

const Toml::array_type& list_of(const Toml& value, const std::string& where, const Rule& rule) {
  if (!value.is_array()) fail(value, where, "it must be a list [...]");
  const Toml::array_type& list = value.as_array();
  if (list.size() > rule.at_most)
    throw codegen::Error(fmt::format("{}: {} has {} elements; at most {} are allowed", place_of(value), where,
                                     list.size(), rule.at_most));
  return list;
}

std::string show_value(bool field) {
  return field ? "true" : "false";
}
std::string show_value(int field) {
  return std::to_string(field);
}
std::string show_value(unsigned long long field) {
  return std::to_string(field);
}

std::string show_value(double field) {
  // TOML needs a digit on both sides of the point: "1e-06" is a number, "1." is not.
  const std::string text = shortest_text(field);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string show_value(const std::string& field) {
  return toml_text(field);
}

std::string show_cells(const std::vector<std::string>& cells) {
  std::string result;
  for (const std::string& cell : cells) {
    const auto number = finite_number(cell);
    // The largest double is written as a text, because read_value() would take the number for an overflow.
    const bool is_bare =
        number && shortest_text(*number) == cell && std::abs(*number) < std::numeric_limits<double>::max();
    result += (result.empty() ? "" : ", ") + (is_bare ? cell : show_value(cell));
  }
  return "[" + result + "]";
}

std::string show_value(const NoiseConfig& field) {
  if (field.sensors.size() == 1) return toml_text(format_noise(field));
  std::vector<std::string> each;
  for (const SensorNoise& noise : field.sensors) each.push_back(format_noise(noise));
  return show_value(each);
}

std::string show_value(const std::array<double, 2>& field) {
  return fmt::format("[{}, {}]", show_value(field[0]), show_value(field[1]));
}

std::string show_value(const EvaluationWindow& field) {
  std::string text = fmt::format("{{ name = {}", toml_text(field.name));
  if (field.from_s > 0.0) text += fmt::format(", from_s = {}", show_value(field.from_s));
  if (std::isfinite(field.to_s)) text += fmt::format(", to_s = {}", show_value(field.to_s));
  return text + " }";
}

std::string show_parameters(const std::vector<std::pair<std::string, double>>& values,
                            const std::vector<std::pair<std::string, std::array<double, 2>>>& ranges) {
  std::vector<std::string> members;
  for (const auto& [name, value] : values) {
    const auto range =
        std::find_if(ranges.begin(), ranges.end(), [&, n = name](const auto& r) { return r.first == n; });
    members.push_back(
        fmt::format("{} = {}", name, range == ranges.end() ? show_value(value) : show_value(range->second)));
  }
  return members.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(members, ", "));
}

}  // namespace nlo::trainer
