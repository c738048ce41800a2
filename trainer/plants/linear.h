// SPDX-License-Identifier: MIT
// Linear plant dx/dt = A x + B u, y = C x. Tests use it because its exact results are known: its KKL map T solves a
// Sylvester equation, and its trajectories follow from a matrix exponential.
#pragma once

#include "trainer/plants/plant.h"

namespace nlo::trainer {

class LinearPlant : public Plant {
 public:
  /// A n_x x n_x, C n_y x n_x, B n_x x n_u, with a channel for each column of B (none: autonomous).
  LinearPlant(std::string name, std::vector<codegen::Channel> states, std::vector<codegen::Channel> outputs,
              Eigen::MatrixXd a, Eigen::MatrixXd c, std::vector<codegen::Channel> inputs = {}, Eigen::MatrixXd b = {})
      : Plant(std::move(name), std::move(states), std::move(outputs), std::move(inputs)),
        a_(std::move(a)),
        b_(std::move(b)),
        c_(std::move(c)) {}

  const Eigen::MatrixXd& a() const { return a_; }
  const Eigen::MatrixXd& b() const { return b_; }
  const Eigen::MatrixXd& c() const { return c_; }

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override { return a_ * x; }
  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return c_ * x; }
  Eigen::MatrixXd input_field(const Eigen::MatrixXd& x, Eigen::Index input) const override {
    return b_.col(input).replicate(1, x.cols());
  }

 private:
  Eigen::MatrixXd a_, b_, c_;
};

}  // namespace nlo::trainer
