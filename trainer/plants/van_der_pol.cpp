// SPDX-License-Identifier: MIT
// Van der Pol oscillator (22):
//   dx1/dt = x2
//   dx2/dt = mu (1 - x1^2) x2 - x1 + u,   y = x1
// For mu = 1 (the paper's) and u = 0 its limit cycle has amplitude 2.00862 and period 6.66329.
#include "trainer/plants/builtin.h"

namespace nlo::trainer {
namespace {

class VanDerPol final : public Plant {
 public:
  explicit VanDerPol(double mu)
      : Plant("van_der_pol", channels({"x1", "x2"}), channels({"y"}), channels({"u"})), mu_(mu) {}

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override {
    const auto x1 = x.row(0).array(), x2 = x.row(1).array();
    Eigen::MatrixXd dx(2, x.cols());
    dx.row(0) = x2;
    dx.row(1) = mu_ * (1.0 - x1.square()) * x2 - x1;
    return dx;
  }

  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return x.topRows<1>(); }

  Eigen::MatrixXd input_field(const Eigen::MatrixXd& x, Eigen::Index /*input*/) const override {
    return Eigen::Vector2d(0.0, 1.0).replicate(1, x.cols());
  }

 private:
  double mu_;
};

}  // namespace

std::unique_ptr<Plant> make_van_der_pol(const PlantParameters& parameters) {
  return std::make_unique<VanDerPol>(parameters[0].second);
}

}  // namespace nlo::trainer
