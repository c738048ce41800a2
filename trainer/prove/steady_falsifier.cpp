// SPDX-License-Identifier: MIT
#include "trainer/prove/steady_falsifier.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/reference/reference_network.h"
#include "codegen/reference/rk4.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/prove/latent_memory.h"
#include "trainer/prove/lipschitz.h"

namespace nlo::trainer {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

class Attack {
 public:
  Attack(const codegen::Model& model, const Plant& plant, const StateRegion& region)
      : model_(model), plant_(plant), region_(region), memory_(model), observer_(model) {}

  /// Returns x at each sample, n_x x (steps + 1). w (n_x x steps) is held over each step. Empty if x leaves the region.
  std::optional<Matrix> path(const Vector& start, const Matrix& w) const {
    constexpr int kParts = 4;
    Matrix x(plant_.nx(), memory_.steps + 1);
    x.col(0) = start;
    for (Eigen::Index k = 0; k < memory_.steps; ++k) {
      Matrix now = x.col(k);
      for (int part = 0; part < kParts; ++part) {
        now = codegen::rk4_step(now, model_.sample_period_s / kParts,
                                [&](double, const Matrix& at) { return Matrix(plant_.derivative(at) + w.col(k)); });
        if (!region_.contains(now.col(0))) return std::nullopt;
      }
      x.col(k + 1) = now;
    }
    return x;
  }

  /// Returns x_hat - x at the last sample, with the noise v (n_y x (steps + 1)).
  Vector error(const Matrix& x, const Matrix& v) {
    const Matrix y = plant_.output(x) + v;
    observer_.reset();
    for (Eigen::Index k = 0; k < y.cols(); ++k) observer_.step(y.col(k));
    return observer_.estimate() - x.rightCols(1);
  }

  /// Returns the noise of size `noise` that moves x_hat_i furthest in the direction `sign`, for the present state of
  /// the observer.
  Matrix worst_noise(Eigen::Index i, double sign, double noise) const {
    const Eigen::Index ny = plant_.ny(), nz = model_.nz();
    const Matrix jacobian = inverse_map_jacobian(model_, observer_.latent(), observer_.output());
    Matrix of_noise = jacobian.row(i).head(nz) * memory_.noise;
    of_noise.leftCols(ny) += jacobian.row(i).tail(ny);
    Matrix v(ny, memory_.steps + 1);
    for (Eigen::Index back = 0; back <= memory_.steps; ++back)
      for (Eigen::Index j = 0; j < ny; ++j)
        v(j, memory_.steps - back) = std::copysign(noise, sign * of_noise(0, back * ny + j));
    return v;
  }

  /// Returns the disturbance of size `size` that moves x_hat_i - x_i furthest in the direction `sign`, block by block.
  /// The effect of a push in each block on the error is simulated.
  std::optional<Matrix> worst_push(const Vector& start, const Matrix& v, Eigen::Index i, double sign, double size) {
    constexpr Eigen::Index kBlocks = 16;
    constexpr double kSmall = 0.05;
    Matrix w = Matrix::Zero(plant_.nx(), memory_.steps);
    if (size == 0.0) return w;
    const auto still = path(start, w);
    if (!still) return std::nullopt;
    const double at_rest = error(*still, v)(i);
    Matrix signs = w;
    for (Eigen::Index block = 0; block < kBlocks; ++block) {
      // Blocks near the end are shorter, because the latest disturbances affect the error most.
      const auto edge = [&](Eigen::Index b) {
        const double part = static_cast<double>(b) / kBlocks;
        return static_cast<Eigen::Index>((1.0 - (1.0 - part) * (1.0 - part)) * static_cast<double>(memory_.steps));
      };
      const Eigen::Index from = edge(block), count = edge(block + 1) - from;
      for (Eigen::Index p = 0; p < plant_.nx() && count > 0; ++p) {
        Matrix pushed = w;
        pushed.block(p, from, 1, count).setConstant(kSmall * size);
        const auto moved = path(start, pushed);
        if (!moved) continue;
        signs.block(p, from, 1, count).setConstant(sign * (error(*moved, v)(i) - at_rest) < 0.0 ? -size : size);
      }
    }
    return signs;
  }

 private:
  const codegen::Model& model_;
  const Plant& plant_;
  const StateRegion& region_;
  LatentMemory memory_;
  codegen::ReferenceObserver<double> observer_;
};

}  // namespace

SteadyFound largest_steady_error(const codegen::Model& model, const Plant& plant, const StateRegion& region,
                                 const SteadyStates& states, const Matrix& starts, const SteadyQuestion& question) {
  // Each round uses the Jacobian at the point that the noise of the previous round reached.
  constexpr int kRounds = 3;
  Attack attack(model, plant, region);
  const Eigen::Index nx = plant.nx();
  SteadyFound found{Vector::Zero(nx), Vector::Zero(nx), 0};
  Matrix in(model.nz() + plant.ny(), states.x.cols());
  in << states.z, plant.output(states.x);
  const Matrix off = (codegen::ReferenceNetwork<double>(*codegen::inverse_map(model))(in) - states.x).cwiseAbs();
  for (Eigen::Index b = 0; b < off.cols(); ++b)
    if (region.contains(states.x.col(b))) found.approximation = found.approximation.cwiseMax(off.col(b));
  const Eigen::Index steps = LatentMemory(model).steps;
  const Matrix quiet = Matrix::Zero(plant.ny(), steps + 1), still = Matrix::Zero(nx, steps);
  for (const auto& start : starts.colwise()) {
    const auto x = attack.path(start, still);
    if (!x) continue;
    ++found.runs;
    const Vector alone = attack.error(*x, quiet);
    found.approximation = found.approximation.cwiseMax(alone.cwiseAbs());
    if (question.noise == 0.0 && question.disturbance == 0.0) continue;
    for (Eigen::Index i = 0; i < nx; ++i) {
      const double sign = alone(i) < 0.0 ? -1.0 : 1.0;
      auto run = x;
      Matrix v = quiet;
      attack.error(*run, v);
      for (int round = 0; round < kRounds && run; ++round) {
        v = attack.worst_noise(i, sign, question.noise);
        if (const auto w = attack.worst_push(start, v, i, sign, question.disturbance)) run = attack.path(start, *w);
        if (run) found.error = found.error.cwiseMax(attack.error(*run, v).cwiseAbs());
      }
    }
  }
  found.error = found.error.cwiseMax(found.approximation);
  return found;
}

}  // namespace nlo::trainer
