// SPDX-License-Identifier: MIT
// Linear plants, whose T and bounds have closed forms, and observers of them.
#pragma once

#include <string>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "codegen/model/hold.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/prove/forward_map.h"
#include "trainer/prove/robustness.h"

namespace nlo::trainer {

inline codegen::Model model_of(const Plant& plant, const Eigen::VectorXd& eigenvalues, int pairs = 0,
                               const std::string& hold = "first_order") {
  const Eigen::Index nz = eigenvalues.size();
  codegen::Model model;
  model.name = "test";
  model.outputs = plant.outputs();
  model.states = plant.states();
  model.sample_period_s = 0.02;
  model.hold = *codegen::find_hold(hold);
  codegen::linear_latent(model)->pairs = pairs;
  codegen::linear_latent(model)->eigenvalues = eigenvalues;
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Ones(nz, plant.ny());
  model.initial_latent = Eigen::VectorXd::Zero(nz);
  model.output_min = Eigen::VectorXd::Constant(plant.ny(), -1e3);
  model.output_max = Eigen::VectorXd::Constant(plant.ny(), 1e3);
  model.latent_min = Eigen::VectorXd::Constant(nz, -1e3);
  model.latent_max = Eigen::VectorXd::Constant(nz, 1e3);
  return model;
}

inline SimulationConfig simulation_of(const Plant& plant, double horizon_s = 20.0) {
  SimulationConfig config;
  config.horizon_s = horizon_s;
  config.sample_period_s = 0.02;
  config.initial_low.assign(static_cast<std::size_t>(plant.nx()), -1.0);
  config.initial_high.assign(static_cast<std::size_t>(plant.nx()), 1.0);
  return config;
}

inline LinearPlant scalar_plant() {
  return {"scalar", channels({"x"}), channels({"y"}), Eigen::MatrixXd::Constant(1, 1, -0.1),
          Eigen::MatrixXd::Ones(1, 1)};
}

inline LinearPlant oscillator() {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, 0.0;
  return {"oscillator", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

inline LinearPlant damped_third_order() {
  Eigen::Matrix3d a;
  a << 0.0, 1.0, 0.0, -4.0, -0.2, 1.0, 0.0, 0.0, -0.3;
  Eigen::MatrixXd c(2, 3);
  c << 1.0, 0.0, 0.0, 0.0, 1.0, 0.5;
  return {"damped", channels({"x1", "x2", "x3"}), channels({"y1", "y2"}), a, c};
}

/// Returns the observer with the eigenvalues k D and the pseudo-inverse of T as T*. No measurement is clamped.
inline codegen::Model exact_observer(const LinearPlant& plant, codegen::Model model, double k = 1.0) {
  constexpr double kFar = 1e12;
  const Eigen::Index nz = model.nz(), ny = model.ny(), nx = model.nx();
  codegen::linear_latent(model)->eigenvalues *= k;
  model.output_min = Eigen::VectorXd::Constant(ny, -kFar);
  model.output_max = Eigen::VectorXd::Constant(ny, kFar);
  model.latent_min = Eigen::VectorXd::Constant(nz, -kFar);
  model.latent_max = Eigen::VectorXd::Constant(nz, kFar);
  codegen::Network inverse;
  inverse.features = Eigen::MatrixXd::Identity(nz, nz + ny);
  inverse.feature_mean = Eigen::VectorXd::Zero(nz);
  inverse.feature_scale = Eigen::VectorXd::Ones(nz);
  const Eigen::MatrixXd t = sylvester_map(plant.a(), plant.c(), latent_system(model));
  inverse.layers = {
      {codegen::least_squares(t, Eigen::MatrixXd::Identity(t.rows(), t.rows())), Eigen::VectorXd::Zero(nx)}};
  inverse.output_mean = Eigen::VectorXd::Zero(nx);
  inverse.output_scale = Eigen::VectorXd::Ones(nx);
  *codegen::inverse_map(model) = std::move(inverse);
  return model;
}

inline Robustness exact_result(const LinearPlant& plant, const codegen::Model& model, double k,
                               const RobustnessQuestion& question, double horizon_s = 20.0) {
  return robustness(plant, exact_observer(plant, model, k), simulation_of(plant, horizon_s), question);
}

}  // namespace nlo::trainer
