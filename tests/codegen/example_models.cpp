// SPDX-License-Identifier: MIT
#include "tests/codegen/example_models.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace nlo::codegen {
namespace {

/// splitmix64: the same weights on every platform. Source: Steele, Lea, Flood 2014.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}

  double operator()(double half_width) {
    std::uint64_t bits = state_ += 0x9e3779b97f4a7c15U;
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebU;
    bits ^= bits >> 31;
    return half_width * (static_cast<double>(bits >> 11) * 0x1p-52 - 1.0);
  }

  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index cols, double half_width) {
    Eigen::MatrixXd values(rows, cols);
    for (Eigen::Index i = 0; i < rows; ++i)
      for (Eigen::Index j = 0; j < cols; ++j) values(i, j) = (*this)(half_width);
    return values;
  }

 private:
  std::uint64_t state_;
};

/// Layers of the given widths (the first is n_u), weights of the size that training starts from.
std::vector<DenseLayer> random_layers(const std::vector<int>& widths, std::uint64_t seed) {
  Uniform uniform(seed);
  std::vector<DenseLayer> layers;
  for (std::size_t l = 0; l + 1 < widths.size(); ++l) {
    const double half_width = std::sqrt(3.0 / widths[l]);
    DenseLayer layer;
    layer.weights = uniform.matrix(widths[l + 1], widths[l], half_width);
    layer.bias = uniform.matrix(widths[l + 1], 1, 0.5);
    layers.push_back(layer);
  }
  return layers;
}

/// One output "y", real eigenvalues, F = ones, T* reads z alone.
Model model_with(const std::string& name, const Eigen::VectorXd& eigenvalues, const std::vector<Channel>& states,
                 const std::vector<int>& hidden) {
  Model m;
  m.name = name;
  m.outputs = {{"y", "m", 0.0}};
  m.states = states;
  m.sample_period_s = 0.02;
  m.eigenvalues = eigenvalues;
  const Eigen::Index nz = eigenvalues.size();
  m.output_injection = Eigen::MatrixXd::Ones(nz, 1);
  m.initial_latent = Eigen::VectorXd::Zero(nz);
  m.output_min = Eigen::VectorXd::Constant(1, -3.0);
  m.output_max = Eigen::VectorXd::Constant(1, 3.0);
  m.latent_max = -4.0 * eigenvalues.cwiseInverse();
  m.latent_min = -m.latent_max;
  m.features = Eigen::MatrixXd::Identity(nz, nz + 1);
  m.feature_mean = Eigen::VectorXd::LinSpaced(nz, -0.1, 0.1);
  m.feature_scale = -0.7 * eigenvalues.cwiseInverse();

  std::vector<int> widths = {static_cast<int>(nz)};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(m.nx());
  m.layers = random_layers(widths, 1);
  m.state_mean = Eigen::VectorXd::LinSpaced(m.nx(), 0.05, 0.25);
  m.state_scale = Eigen::VectorXd::LinSpaced(m.nx(), 1.4, 1.9);
  m.provenance = {{"plant", "Van der Pol"}, {"seed", "1"}, {"norm N(0, 0.5)", "0.17"}};
  return m;
}

}  // namespace

Model paper_model() {
  return model_with("van_der_pol", Eigen::Vector3d(-0.81, -0.83, -0.63), {{"x1", "m", 0.0}, {"x2", "m/s", 0.0}},
                    {50, 50, 50, 50});
}

Model tiny_model() {
  return model_with("tiny", Eigen::Vector2d(-1.0, -4.0), {{"position", "m", 0.0}}, {4});
}

Model linear_model() {
  return model_with("linear", Eigen::Vector2d(-1.0, -4.0), {{"position", "m", 0.0}, {"speed", "m/s", 0.0}}, {});
}

Model activation_model(const std::string& activation) {
  Model m = model_with("tiny_" + activation, Eigen::Vector2d(-2.0, -9.0), {{"x1", "", 0.0}, {"x2", "", 0.0}}, {16, 16});
  m.activation = activation;
  return m;
}

Model hold_model(const std::string& hold) {
  Model m = tiny_model();
  m.name += "_" + hold;
  m.hold = hold;
  return m;
}

Model rig_model() {
  Model m;
  m.name = "rig";
  m.outputs = {{"alpha", "rad", 2.0 * std::numbers::pi}, {"load", "N", 0.0}};
  m.states = {{"alpha_dot", "rad/s", 0.0}, {"load_dot", "N/s", 0.0}, {"phase", "rad", 2.0 * std::numbers::pi}};
  m.sample_period_s = 0.004;
  m.pairs = 2;
  m.eigenvalues.resize(7);
  m.eigenvalues << -40.0, 30.0, -25.0, 35.0, -60.0, -15.0, -2.0;  // pair, pair, real, real, clock

  // F = -D on the column of each output: both settle at z = y.
  m.output_injection = Eigen::MatrixXd::Zero(7, 2);
  m.output_injection.col(0) << 40.0, -30.0, 0.0, 0.0, 60.0, 0.0, 0.0;
  m.output_injection.col(1) << 0.0, 0.0, 25.0, -35.0, 0.0, 15.0, 0.0;
  m.initial_latent = Eigen::VectorXd::Unit(7, 6);
  m.starts_steady = true;
  m.output_min = Eigen::Vector2d(-std::numbers::pi, -5.0);
  m.output_max = Eigen::Vector2d(std::numbers::pi, 5.0);
  m.latent_max = Eigen::VectorXd::Constant(7, 6.0);
  m.latent_min = Eigen::VectorXd::Constant(7, -6.0);

  // z - y for the rows that settle at an output, z for the others, and the load itself.
  m.features = Eigen::MatrixXd::Zero(8, 9);
  m.features.leftCols(7).topRows(7).setIdentity();
  for (const int row : {0, 4}) m.features(row, 7) = -1.0;
  for (const int row : {2, 5}) m.features(row, 8) = -1.0;
  m.features(7, 8) = 1.0;
  m.feature_mean = Eigen::VectorXd::LinSpaced(8, -0.05, 0.05);
  m.feature_scale = Eigen::VectorXd::LinSpaced(8, 0.2, 1.1);
  m.layers = random_layers({8, 32, 24, 3}, 7);
  m.skip = Uniform(8).matrix(3, 8, 0.4);
  m.state_mean = Eigen::Vector3d(0.0, 0.3, -0.1);
  m.state_scale = Eigen::Vector3d(8.0, 20.0, 1.0);
  m.provenance = {{"plant", "logs of a rig"}, {"seed", "2"}};
  return m;
}

std::vector<Model> example_models() {
  return {paper_model(),
          rig_model(),
          tiny_model(),
          activation_model("relu"),
          activation_model("silu"),
          activation_model("tanh"),
          linear_model(),
          hold_model("zero_order"),
          hold_model("rk4")};
}

}  // namespace nlo::codegen
