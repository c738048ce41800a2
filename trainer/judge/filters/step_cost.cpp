// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/step_cost.h"
#include "trainer/plants/equations_of_plant.h"

#include <cctype>
#include <string>

namespace nlo::trainer {
namespace {

bool is_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

}  // namespace

StepCost cost_of_expression(std::string_view text) {
  StepCost cost;
  bool operand = false;  // true if an operator here has an operand to its left; else it is a sign
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    if (is_name(c) || c == '.') {
      const bool number = std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.';
      while (i + 1 < text.size() &&
             (is_name(text[i + 1]) || text[i + 1] == '.' ||
              (number && (text[i] == 'e' || text[i] == 'E') && (text[i + 1] == '-' || text[i + 1] == '+'))))
        ++i;
      const std::size_t next = text.find_first_not_of(" \t\n", i + 1);
      if (!number && next != std::string_view::npos && text[next] == '(') cost.functions += 1.0;
      operand = true;
    } else if (c == '^') {
      const std::size_t next = text.find_first_not_of(" \t\n", i + 1);
      const bool ends = next + 1 >= text.size() || (!is_name(text[next + 1]) && text[next + 1] != '.');
      if (next != std::string_view::npos && (text[next] == '2' || text[next] == '3') && ends)
        cost.operations += text[next] - '1';
      else
        cost.functions += 1.0;
      operand = false;
    } else if (std::string_view("+-*/<>=!&|?").find(c) != std::string_view::npos) {
      if (operand) cost.operations += 1.0;
      operand = false;  // the second character of <=, == does not count
    } else {
      operand = c == ')';
    }
  }
  return cost;
}

PlantCost plant_cost(const PlantConfig& plant) {
  const PlantConfig equations = equations_of(plant);
  PlantCost cost;
  for (const std::string& expression : equations.derivative) cost.f = cost.f + cost_of_expression(expression);
  for (const auto& row : equations.input_field)
    for (const std::string& expression : row)
      if (expression != "0") cost.f = cost.f + cost_of_expression(expression) + StepCost{2.0, 0.0};
  for (const std::string& expression : equations.outputs) cost.h = cost.h + cost_of_expression(expression);
  return cost;
}

StepCost rk4_cost(double n, const StepCost& f) {
  return f * 4.0 + StepCost{13.0 * n, 0.0};  // per state: z + c h k three times, and the weighted sum of four slopes
}

StepCost sigma_point_cost(double n, double ny, bool extended, const PlantCost& plant, double steps) {
  const double points = 2.0 * n + 1.0, columns = extended ? 2.0 * n : 3.0 * n + 1.0;
  StepCost cost = rk4_cost(n, plant.f) * (points * steps) + plant.h * (points * ny);
  cost.operations += 2.0 * (1.0 + ny) * 2.0 * n * n;                                   // points about x, twice
  cost.operations += extended ? 2.0 * n * n : 4.0 * points * n;                        // columns of W
  cost.operations += columns * n * (2.0 * n + 1.0);                                    // Gram and Schmidt
  cost.operations += ny * (4.0 * n * n + 8.0 * n + (extended ? 0.0 : 6.0 * n) + 8.0);  // Potter's updates
  cost.functions += n + ny;                                                            // square roots
  return cost;
}

StepCost bank_cost(double members, double n, double ny, const StepCost& one) {
  return (one + StepCost{2.0 * n + 4.0 * ny + 2.0, ny + 1.0}) * members;  // logarithms, exponentials, the mean
}

StepCost cost_of_constant_acceleration() {
  // F x 6, F P F' 24 (without its zeros and ones), q Q 15, gain 4, state 6, Joseph form by its sparse factor 45.
  return {100.0, 0.0};
}

}  // namespace nlo::trainer
