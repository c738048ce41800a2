// SPDX-License-Identifier: MIT
// Example 1 of the paper (21):
//   dx1/dt =  x2 + sin x1
//   dx2/dt = -x1 + cos x2,   y = x1
#include "trainer/plants/builtin.h"

namespace nlo::trainer {
namespace {

class SineCosine final : public Plant {
 public:
  SineCosine() : Plant("sine_cosine", channels({"x1", "x2"}), channels({"y"})) {}

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override {
    const auto x1 = x.row(0).array(), x2 = x.row(1).array();
    Eigen::MatrixXd dx(2, x.cols());
    dx.row(0) = x2 + x1.sin();
    dx.row(1) = x2.cos() - x1;
    return dx;
  }

  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return x.topRows<1>(); }
};

}  // namespace

std::unique_ptr<Plant> make_sine_cosine(const PlantParameters&) {
  return std::make_unique<SineCosine>();
}

}  // namespace nlo::trainer
