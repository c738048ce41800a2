// SPDX-License-Identifier: MIT
// Models with an inverse map of random weights: three latent states, two outputs, two states.
#pragma once

#include <Eigen/Core>
#include <random>
#include <string>
#include <utility>

#include "codegen/model/activations.h"
#include "codegen/model/model.h"

namespace nlo::trainer {

inline constexpr int kNz = 3, kNy = 2, kNx = 2;

inline Eigen::MatrixXd random(std::mt19937& engine, Eigen::Index rows, Eigen::Index cols, double scale = 1.0) {
  std::normal_distribution<double> normal(0.0, scale);
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(engine); });
}

/// Returns a model with an inverse map and channels, which is all that the tested functions read.
inline codegen::Model model_with(codegen::Network network) {
  codegen::Model model;
  for (int i = 0; i < kNx; ++i) model.states.push_back({"x", "", 0.0});
  for (int i = 0; i < kNy; ++i) model.outputs.push_back({"y", "", 0.0});
  model.initial_latent = Eigen::VectorXd::Zero(kNz);
  *codegen::inverse_map(model) = std::move(network);
  return model;
}

inline codegen::Model random_model(unsigned seed, const std::string& activation, int hidden_layers) {
  std::mt19937 engine(seed);
  codegen::Network network;
  const int nu = kNz + (seed % 2 == 0 ? kNy : 0);  // every other one reads y
  network.features = Eigen::MatrixXd::Identity(nu, kNz + kNy);
  network.feature_mean = random(engine, nu, 1);
  network.feature_scale = random(engine, nu, 1).cwiseAbs().array() + 0.2;
  network.activation = codegen::activation_named(activation).kind;
  int width = nu;
  for (int l = 0; l <= hidden_layers; ++l) {
    const int out = l == hidden_layers ? kNx : 6;
    network.layers.push_back({random(engine, out, width, 0.7), random(engine, out, 1)});
    width = out;
  }
  if (seed % 3 == 0) network.skip = random(engine, kNx, nu);
  network.output_mean = random(engine, kNx, 1);
  network.output_scale = random(engine, kNx, 1).cwiseAbs().array() + 0.5;
  return model_with(std::move(network));
}

}  // namespace nlo::trainer
