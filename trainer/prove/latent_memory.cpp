// SPDX-License-Identifier: MIT
#include "trainer/prove/latent_memory.h"

#include <algorithm>
#include <cmath>

#include "codegen/model/latent_step.h"
#include "trainer/prove/latent_system.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {

LatentMemory::LatentMemory(const codegen::Model& model) {
  constexpr double kForgotten = 1e-7;
  constexpr Eigen::Index kMost = 4096;
  const codegen::StepMatrices step = codegen::latent_step(model, model.sample_period_s);
  const Eigen::Index nz = model.nz(), ny = step.b0.cols();
  a = codegen::block_diagonal(model, step.a_minus_1) + Eigen::MatrixXd::Identity(nz, nz);
  b0 = step.b0;
  b1 = step.b1;
  double slowest = 0.0;  // |A| of the slowest mode, because A is normal
  for (const LatentMode& mode : modes_of(latent_system(model)))
    slowest = std::max(slowest, mode.rows == 2 ? std::hypot(a(mode.row, mode.row), a(mode.row + 1, mode.row))
                                               : std::abs(a(mode.row, mode.row)));
  slowest *= 1.0 + 8.0 * kUnit;
  const double wanted = std::ceil(std::log(kForgotten) / std::log(slowest));
  steps = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(std::min(wanted, 1.0 * kMost)), 8, kMost);
  tail = upward(std::pow(slowest, static_cast<double>(steps)) / (1.0 - slowest), 16 * steps);
  powers.resize(nz, steps * nz);
  noise.resize(nz, (steps + 1) * ny);
  Eigen::MatrixXd power = Eigen::MatrixXd::Identity(nz, nz);
  noise.leftCols(ny) = b1;
  for (Eigen::Index i = 0; i < steps; ++i) {
    powers.middleCols(i * nz, nz) = power;
    const Eigen::MatrixXd next = a * power;
    noise.middleCols((i + 1) * ny, ny) = power * b0;
    if (i + 1 < steps) noise.middleCols((i + 1) * ny, ny) += next * b1;
    power = next;
  }
  // Two products per step; the entries of a pair are at most sqrt(2) times its size.
  rounding = gamma(4 * (nz + 2) * steps) * 2.0;
}

Eigen::VectorXd LatentMemory::largest(const Eigen::MatrixXd& rows, const Eigen::VectorXd& noise_size,
                                      const Eigen::VectorXd& step_size, const Eigen::MatrixXd& feedthrough) const {
  const Eigen::Index nz = a.rows(), ny = noise_size.size();
  Eigen::VectorXd result = Eigen::VectorXd::Zero(rows.rows());
  Eigen::MatrixXd of_noise = rows * noise;
  if (feedthrough.size() != 0) of_noise.leftCols(ny) += feedthrough;
  for (Eigen::Index i = 0; i <= steps; ++i) result += of_noise.middleCols(i * ny, ny).cwiseAbs() * noise_size;
  if (!step_size.isZero(0.0)) {
    const Eigen::MatrixXd of_steps = rows * powers;
    for (Eigen::Index i = 0; i < steps; ++i) result += of_steps.middleCols(i * nz, nz).cwiseAbs() * step_size;
  }
  // Adds the part that is not stored and the rounding errors: |row| times the sizes of its factors.
  const Eigen::VectorXd norms = rows.rowwise().norm();
  const double injected = ((b0.cwiseAbs() + b1.cwiseAbs()) * noise_size).norm() + step_size.norm();
  const double kept = (noise.cwiseAbs().rowwise().sum() * noise_size.maxCoeff()).norm() +
                      (powers.cwiseAbs().rowwise().sum() * step_size.maxCoeff()).norm();
  result += norms * (tail * injected + (rounding + gamma(nz + 2)) * kept);
  return upward(result, 2 * (steps + nz) * (nz + ny));
}

}  // namespace nlo::trainer
