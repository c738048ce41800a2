// SPDX-License-Identifier: MIT
#include "trainer/identify/step_cost.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

namespace nlo::trainer {
namespace {

bool is_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

StepCost cost_of_all(const std::vector<std::string>& expressions) {
  StepCost cost;
  for (const std::string& expression : expressions) cost = cost + cost_of_expression(expression);
  return cost;
}

/// f at the four stages of RK4, h, and what combines the stages, at the 2 n_x + 1 points of either filter.
StepCost cost_of_points(const Identification& identification, double period_s) {
  const PlantConfig& plant = identification.plant;
  const auto nx = static_cast<double>(plant.states.size());
  const double longest = identification.identify.longest_step_s;
  const double steps = longest > 0.0 ? std::max(1.0, std::ceil(period_s / longest - 1e-9)) : 1.0;
  constexpr double kCombining = 13.0;  // per state: z + c h k three times, and the weighted sum of four slopes
  const StepCost stages = cost_of_all(plant.derivative) * 4.0 + StepCost{kCombining * nx, 0.0};
  return (stages * steps + cost_of_all(plant.outputs)) * (2.0 * nx + 1.0);
}

/// A x = b for a symmetric n x n and m right-hand sides.
double solving(double n, double m) {
  return n * n * n / 3.0 + 2.0 * n * n * m;
}

}  // namespace

StepCost cost_of_expression(std::string_view text) {
  StepCost cost;
  bool operand = false;  // whether an operator here has something to its left: else it is a sign
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
      operand = false;  // the second sign of <=, == counts no more
    } else {
      operand = c == ')';
    }
  }
  return cost;
}

StepCost cost_of_ekf(const Identification& identification, double period_s) {
  const auto nx = static_cast<double>(identification.plant.states.size());
  const auto ny = static_cast<double>(identification.plant.outputs.size());
  StepCost cost = cost_of_points(identification, period_s);
  cost.operations += 2.0 * nx * (nx + ny);                                            // two Jacobians by differences
  cost.operations += 4.0 * nx * nx * nx + nx;                                         // J P J' + Q
  cost.operations += 2.0 * ny * nx * nx + 2.0 * ny * ny * nx + ny + solving(ny, nx);  // H P, S, K
  cost.operations += ny + 2.0 * nx * ny;                                              // innovation and state
  cost.operations += 2.0 * nx * nx * ny + 4.0 * nx * nx * nx + 2.0 * nx * nx * ny + nx * ny + nx * nx;  // Joseph form
  return cost;
}

StepCost cost_of_ukf(const Identification& identification, double period_s) {
  const auto nx = static_cast<double>(identification.plant.states.size());
  const auto ny = static_cast<double>(identification.plant.outputs.size());
  const double points = 2.0 * nx + 1.0;
  StepCost cost = cost_of_points(identification, period_s);
  cost = cost + StepCost{nx * nx * nx / 3.0 + 3.0 * nx * nx, nx} * 2.0;         // Cholesky, points; nx square roots
  cost.operations += points * (2.0 * nx + nx + 3.0 * nx * nx) + nx;             // mean, differences, P + Q
  cost.operations += points * (4.0 * ny + 3.0 * ny * ny + 2.0 * nx * ny) + ny;  // those of y, cross-covariance
  cost.operations += solving(ny, nx) + 2.0 * ny + 2.0 * nx * ny;                // K, state
  cost.operations += 2.0 * nx * ny * ny + 2.0 * nx * nx * ny + 3.0 * nx * nx;   // P - K S K', symmetric
  return cost;
}

StepCost cost_of_constant_acceleration() {
  // F x 6, F P F' 24 (its zeros and ones left out), q Q 15, gain 4, state 6, Joseph form by its sparse factor 45
  return {100.0, 0.0};
}

}  // namespace nlo::trainer
