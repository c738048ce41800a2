// SPDX-License-Identifier: MIT
// The known equations (codegen/model/equations.h) of eight trajectories side by side: steps of RK4, outputs, and their
// pullbacks.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "codegen/model/equations.h"
#include "trainer/structures/equation_tape.h"

namespace nlo::trainer {

template <class Scalar>
class EquationLanes {
 public:
  using L = Lanes<Scalar>;

  explicit EquationLanes(const codegen::Equations& equations)
      : carried_(equations.carried()),
        states_(equations.nx()),
        derivative_(equations.derivative(), equations.first_parameter(), parameters_of(equations)),
        output_(equations.output(), equations.first_parameter(), parameters_of(equations)),
        to_output_(static_cast<std::size_t>(output_.size())) {
    for (std::vector<L>& to : to_stage_) to.resize(static_cast<std::size_t>(derivative_.size()));
  }

  /// Returns the size of the memory of a step, which its pullback reads.
  int step_size() const { return static_cast<int>(kParts.size()) * derivative_.size(); }
  /// Returns the size of the memory of an output, which its pullback reads. It begins with [x; p]
  /// and u.
  int output_size() const { return output_.size(); }

  /// Advances [x; p] by `h` seconds, in place, by one step of RK4.
  ///   inputs(c, u)  writes u (n_u) at the part c in [0, 1] of the step
  ///   stages        step_size() numbers, which this function fills
  template <class Inputs>
  void step(L* x, L h, const Inputs& inputs, L* stages) const {
    for (std::size_t i = 0; i < kParts.size(); ++i) {
      L* const at = stage(stages, i);
      const L part = h * in_lanes<L>(kParts[i]);
      for (int r = 0; r < carried_; ++r) at[r] = i == 0 ? x[r] : x[r] + part * derivative_.row(stage(stages, i - 1), r);
      inputs(kParts[i], at + carried_);
      derivative_.evaluate(at);
    }
    for (int r = 0; r < carried_; ++r) {
      L sum{};
      for (std::size_t i = 0; i < kParts.size(); ++i)
        sum += in_lanes<L>(kWeights[i]) * derivative_.row(stage(stages, i), r);
      x[r] += h * sum;
    }
  }

  /// Replaces the cotangent of [x; p] after a step by the cotangent before the step, in place.
  void step_back(const L* stages, L h, L* cotangent) {
    std::array<L, codegen::Equations::kMostCarried> after;
    std::copy_n(cotangent, carried_, after.begin());
    for (std::size_t i = kParts.size(); i-- > 0;) {
      const bool last = i + 1 == kParts.size();
      const L weight = h * in_lanes<L>(kWeights[i]), part = last ? L{} : h * in_lanes<L>(kParts[i + 1]);
      const L* const later = to_stage_[(i + 1) % 2].data();
      L* const to = to_stage_[i % 2].data();
      const auto to_slope = [&](int r) {
        const L own = weight * after[static_cast<std::size_t>(r)];
        return last ? own : own + part * later[r];
      };
      derivative_.pull_back(stage(stages, i), to_slope, to);
      for (int r = 0; r < carried_; ++r) cotangent[r] += to[r];
    }
  }

  /// Evaluates y and dh/dx from [x; p] and u, which are at the start of `values`.
  void output(L* values) const { output_.evaluate(values); }
  /// Returns y_j after output().
  L output(const L* values, int j) const { return output_.row(values, j); }
  /// Returns dy_j/dx_i after output().
  L slope(const L* values, int j, int i, int outputs) const { return output_.row(values, outputs + j * states_ + i); }
  /// Adds the cotangent of x to `to_x` (n_x). to_row(i) returns the cotangents of y, then those of its slopes, row by
  /// row.
  template <class ToRow>
  void output_back(const L* values, const ToRow& to_row, L* to_x) {
    output_.pull_back(values, to_row, to_output_.data());
    for (int i = 0; i < states_; ++i) to_x[i] += to_output_[static_cast<std::size_t>(i)];
  }

 private:
  static constexpr auto kParts = codegen::Equations::kParts, kWeights = codegen::Equations::kWeights;

  static std::vector<double> parameters_of(const codegen::Equations& equations) {
    std::vector<double> parameters;
    for (int i = 0; i < equations.first_part() - equations.first_parameter(); ++i)
      parameters.push_back(equations.parameter(i));
    return parameters;
  }
  template <class Number>
  Number* stage(Number* stages, std::size_t i) const {
    return stages + i * static_cast<std::size_t>(derivative_.size());
  }

  int carried_, states_;
  EquationTape<Scalar> derivative_, output_;
  std::vector<L> to_output_;
  std::array<std::vector<L>, 2> to_stage_;  ///< cotangents of the values of a stage and of the stage after it
};

}  // namespace nlo::trainer
