// SPDX-License-Identifier: MIT
#include "trainer/structures/known_equations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <regex>

namespace nlo::trainer {
namespace {

bool is_encoded(const std::vector<Encoding>& encodings, std::size_t i) {
  return i < encodings.size() && encodings[i] == Encoding::kSincos;
}

bool has_unwrapped(const std::vector<double>& wraps, const std::vector<Encoding>& encodings) {
  for (std::size_t i = 0; i < wraps.size(); ++i)
    if (wraps[i] != 0.0 && (!is_encoded(encodings, i) || wraps[i] != 2.0 * std::numbers::pi)) return true;
  return false;
}

/// Returns the position of the parenthesis that closes the one at `open`. The text has been parsed before, so it
/// exists.
std::size_t closing(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')' && --depth == 0) return i;
  }
  return text.size();
}

/// Replaces sqrt(v) by sqrt(max(v, 0)), because an estimate may have values that the plant cannot have, such as a level
/// below 0.
std::string with_defined_roots(std::string text) {
  static const std::regex kRoot("\\bsqrt\\s*\\(");
  std::smatch found;
  std::string done;
  while (std::regex_search(text, found, kRoot)) {
    const auto open = static_cast<std::size_t>(found.position() + found.length() - 1);
    const std::size_t end = closing(text, open);
    const std::string of = text.substr(open + 1, end - open - 1);
    done += found.prefix().str();
    done += of.starts_with("max(") && closing(of, 3) + 1 == of.size()
                ? fmt::format("sqrt({})", with_defined_roots(of))
                : fmt::format("sqrt(max({}, 0))", with_defined_roots(of));
    text = text.substr(std::min(end + 1, text.size()));
  }
  return done + text;
}

/// Returns the indices of the estimated states, then those of the other states.
std::vector<std::size_t> estimated_first(const PlantConfig& plant) {
  std::vector<std::size_t> order;
  const auto is_new = [&order](std::size_t i) { return std::ranges::find(order, i) == order.end(); };
  for (const std::string& name : plant.estimated)
    order.push_back(static_cast<std::size_t>(std::ranges::find(plant.states, name) - plant.states.begin()));
  for (std::size_t i = 0; i < plant.states.size(); ++i)
    if (is_new(i)) order.push_back(i);
  return order;
}

}  // namespace

bool has_unwrapped_angle(const PlantConfig& plant) {
  return has_unwrapped(plant.state_wraps, plant.state_encodings) ||
         has_unwrapped(plant.output_wraps, plant.output_encodings);
}

KnownEquations known_equations(const PlantConfig& plant, bool reads_inputs, const std::vector<std::string>& inputs) {
  KnownEquations known;
  known.texts.parameters = plant.parameters;
  if (reads_inputs) {
    for (const std::string& input : inputs) known.inputs.push_back({input, ""});
  } else {
    for (const std::string& input : plant.inputs) known.texts.parameters.emplace_back(input, 0.0);
  }
  // sin(NAME) and cos(NAME) of an angle are states.
  const auto of_circles = [&plant](std::string text) {
    for (std::size_t i = 0; i < plant.states.size(); ++i) {
      if (!is_encoded(plant.state_encodings, i)) continue;
      const std::string& name = plant.states[i];
      for (const char* function : {"sin", "cos"})
        text = std::regex_replace(text, std::regex(std::string("\\b") + function + "\\s*\\(\\s*" + name + "\\s*\\)"),
                                  name + "_" + function);
    }
    return with_defined_roots(text);
  };
  const std::vector<std::size_t> order = estimated_first(plant);
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t i = order[place], before = known.states.size();
    std::string f = plant.derivative[i];
    for (std::size_t j = 0; reads_inputs && i < plant.input_field.size() && j < plant.inputs.size(); ++j)
      if (const std::string& g = plant.input_field[i][j]; g != "0")
        f += fmt::format(" + ({}) * {}", g, plant.inputs[j]);
    f = of_circles(f);
    const std::string& name = plant.states[i];
    if (is_encoded(plant.state_encodings, i)) {
      known.states.insert(known.states.end(), {{name + "_sin", ""}, {name + "_cos", ""}});
      known.texts.derivative.insert(known.texts.derivative.end(),
                                    {fmt::format("{}_cos * ({})", name, f), fmt::format("-{}_sin * ({})", name, f)});
      known.on_circle.insert(known.on_circle.end(), 2, true);
    } else {
      known.states.push_back({name, ""});
      known.texts.derivative.push_back(f);
      known.on_circle.push_back(false);
    }
    if (plant.estimated.empty() || place < plant.estimated.size()) continue;
    for (std::size_t k = before; k < known.states.size(); ++k) known.texts.unestimated.push_back(known.states[k].name);
  }
  for (std::size_t j = 0; j < plant.outputs.size(); ++j) {
    const std::string name = j < plant.output_names.size() ? plant.output_names[j] : "";
    if (is_encoded(plant.output_encodings, j)) {
      for (const char* function : {"sin", "cos"}) {
        known.outputs.push_back({name + "_" + function, ""});
        known.texts.outputs.push_back(of_circles(fmt::format("{}({})", function, plant.outputs[j])));
      }
    } else {
      known.outputs.push_back({name, ""});
      known.texts.outputs.push_back(of_circles(plant.outputs[j]));
    }
  }
  return known;
}

}  // namespace nlo::trainer
