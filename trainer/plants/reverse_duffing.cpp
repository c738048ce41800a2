// SPDX-License-Identifier: MIT
// Reverse Duffing oscillator (23), driven as in example 3:
//   dx1/dt = x2^3
//   dx2/dt = -x1 + u,   y = x1
// Without u, 2 x1^2 + x2^4 is constant along every trajectory.
#include "trainer/plants/builtin.h"

namespace nlo::trainer {
namespace {

class ReverseDuffing final : public Plant {
 public:
  ReverseDuffing() : Plant("reverse_duffing", channels({"x1", "x2"}), channels({"y"}), channels({"u"})) {}

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override {
    Eigen::MatrixXd dx(2, x.cols());
    dx.row(0) = x.row(1).array().cube();
    dx.row(1) = -x.row(0);
    return dx;
  }

  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return x.topRows<1>(); }

  Eigen::MatrixXd input_field(const Eigen::MatrixXd& x, Eigen::Index /*input*/) const override {
    return Eigen::Vector2d(0.0, 1.0).replicate(1, x.cols());
  }
};

}  // namespace

std::unique_ptr<Plant> make_reverse_duffing(const PlantParameters&) {
  return std::make_unique<ReverseDuffing>();
}

}  // namespace nlo::trainer
