// SPDX-License-Identifier: MIT
// The value of one key: reads it from TOML and checks its rule, writes it as TOML and in words. Overloaded by the type
// of the field.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/config/toml.h"

namespace nlo::trainer {

/// The value that `nlo new` writes where the user has to choose one. Reading it is an error.
inline constexpr std::string_view kChoose = "CHOOSE";

/// A condition on a value in addition to its type; in a list it applies to each element.
struct Rule {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_is_open = false, high_is_open = false;
  std::vector<std::string> one_of = {};  ///< for strings
  bool identifier = false;               ///< for strings
  std::size_t at_most = 1000;            ///< largest number of elements of a list

  std::string in_words() const;  ///< "> 0", "0 .. 1", "one of ..."; empty without a condition
};

inline Rule any() {
  return {};
}
inline Rule positive() {
  return {.low = 0.0, .low_is_open = true};
}
inline Rule negative() {
  return {.high = 0.0, .high_is_open = true};
}
inline Rule at_least(double low) {
  return {.low = low};
}
inline Rule between(double low, double high) {
  return {.low = low, .high = high};
}
inline Rule share_below_one() {
  return {.low = 0.0, .high = 1.0, .high_is_open = true};
}
inline Rule one_of(std::vector<std::string> names) {
  return {.one_of = std::move(names)};
}
/// Returns the names of an enumeration.
template <Named E>
Rule names_of() {
  return one_of(all_names<E>());
}
inline Rule identifiers() {
  return {.identifier = true};
}

/// read_value(value, where, rule, field): `where` is "[training] steps". Throws codegen::Error `FILE:LINE: ...`.
void read_value(const Toml& value, const std::string& where, const Rule& rule, bool& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, int& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, unsigned long long& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, double& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, std::string& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, NoiseConfig& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, std::array<double, 2>& field);
void read_value(const Toml& value, const std::string& where, const Rule& rule, EvaluationWindow& field);

/// Reads one of the names that the rule allows: names_of<E>(), or some of them.
template <Named E>
void read_value(const Toml& value, const std::string& where, const Rule& rule, E& field) {
  std::string name;
  read_value(value, where, rule, name);
  field = from_name<E>(name).value();
}

/// Returns the full turn of an angle in the form of an experiment: "2pi" with its quotes, or a number.
std::string show_wrap(double wrap);

/// Reads the full turn of an angle: a number, "2pi" or "360deg".
void read_wrap(const Toml& value, const std::string& where, double& field);

/// Reads a delay [s] >= 0, or "estimate", which sets `find`.
void read_delay(const Toml& value, const std::string& where, double& delay_s, bool& find);

/// Reads a list of full turns.
void read_wraps(const Toml& value, const std::string& where, std::vector<double>& field);

/// Reads { NAME = number or [low, high], ... }. The value of a parameter with a range is the middle of the range.
void read_parameters(const Toml& value, const std::string& where, std::vector<std::pair<std::string, double>>& values,
                     std::vector<std::pair<std::string, std::array<double, 2>>>& ranges);

/// Writes parameters and ranges as TOML.
std::string show_parameters(const std::vector<std::pair<std::string, double>>& values,
                            const std::vector<std::pair<std::string, std::array<double, 2>>>& ranges);

/// Returns the elements of a list. Throws codegen::Error unless it is a list of at most rule.at_most elements.
const Toml::array_type& list_of(const Toml& value, const std::string& where, const Rule& rule);

/// Returns cells of a log as a list: numbers bare, words in quotes.
std::string show_cells(const std::vector<std::string>& cells);

template <class T>
void read_value(const Toml& value, const std::string& where, const Rule& rule, std::vector<T>& field) {
  std::vector<T> result;
  for (const Toml& element : list_of(value, where, rule)) {
    const std::string index = std::to_string(result.size());
    read_value(element, where + "[" + index + "]", rule, result.emplace_back());
  }
  field = std::move(result);
}

std::string show_value(bool field);
std::string show_value(int field);
std::string show_value(unsigned long long field);
std::string show_value(double field);
std::string show_value(const std::string& field);
std::string show_value(const NoiseConfig& field);
std::string show_value(const std::array<double, 2>& field);
std::string show_value(const EvaluationWindow& field);

template <Named E>
std::string show_value(E field) {
  return toml_text(to_name(field));
}

template <class T>
std::string show_value(const std::vector<T>& field) {
  std::string result;
  for (const T& element : field) result += (result.empty() ? "" : ", ") + show_value(element);
  return "[" + result + "]";
}

inline std::string type_of(const bool&) {
  return "true or false";
}
inline std::string type_of(const int&) {
  return "integer";
}
inline std::string type_of(const unsigned long long&) {
  return "integer";
}
inline std::string type_of(const double&) {
  return "number";
}
inline std::string type_of(const std::string&) {
  return "text";
}
inline std::string type_of(const NoiseConfig&) {
  return "\"none\", \"gaussian:SIGMA\", \"uniform:HALF_WIDTH\" or \"student:SCALE:FREEDOM\", or a list of these";
}
inline std::string type_of(const std::array<double, 2>&) {
  return "[re, im]";
}
template <Named E>
std::string type_of(const E&) {
  return "text";
}
inline std::string type_of(const EvaluationWindow&) {
  return "{ name = TEXT, from_s = number, to_s = number }";
}

template <class T>
std::string type_of(const std::vector<T>&) {
  return std::string("[").append(type_of(T{})).append(", ...]");
}

}  // namespace nlo::trainer
