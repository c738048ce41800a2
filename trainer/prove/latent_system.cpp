// SPDX-License-Identifier: MIT
#include "trainer/prove/latent_system.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace nlo::trainer {

LatentSystem latent_system(const codegen::Model& model) {
  const codegen::LinearLatent& latent = *codegen::linear_latent(model);
  return {latent.eigenvalues, latent.pairs, latent.output_injection};
}

std::vector<LatentMode> modes_of(const LatentSystem& system) {
  const Eigen::VectorXd& e = system.eigenvalues;
  const Eigen::MatrixXd& f = system.injection;
  std::vector<LatentMode> modes;
  for (Eigen::Index r = 0; r < system.nz();) {
    const bool pair = r < 2 * system.pairs;
    LatentMode mode;
    mode.row = r;
    mode.rows = pair ? 2 : 1;
    mode.lambda = {e(r), pair ? e(r + 1) : 0.0};
    mode.f = f.row(r).cast<std::complex<double>>();
    if (pair) mode.f += std::complex<double>(0.0, 1.0) * f.row(r + 1);
    mode.driven = !mode.f.isZero(0.0);
    r += mode.rows;
    modes.push_back(std::move(mode));
  }
  return modes;
}

double slowest(const LatentSystem& system, bool driven_only) {
  double rate = -std::numeric_limits<double>::infinity();
  for (const LatentMode& mode : modes_of(system))
    if (mode.driven || !driven_only) rate = std::max(rate, mode.lambda.real());
  return rate;
}

double fastest(const LatentSystem& system) {
  double rate = 0.0;
  for (const LatentMode& mode : modes_of(system)) rate = std::max(rate, std::abs(mode.lambda));
  return rate;
}

Eigen::MatrixXd real_rows(const std::vector<LatentMode>& modes, const Eigen::MatrixXcd& rows) {
  Eigen::Index nz = 0;
  for (const LatentMode& mode : modes) nz += mode.rows;
  Eigen::MatrixXd z(nz, rows.cols());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    z.row(modes[i].row) = rows.row(static_cast<Eigen::Index>(i)).real();
    if (modes[i].rows == 2) z.row(modes[i].row + 1) = rows.row(static_cast<Eigen::Index>(i)).imag();
  }
  return z;
}

Eigen::MatrixXd apply_d(const LatentSystem& system, const Eigen::MatrixXd& z) {
  Eigen::MatrixXd product(z.rows(), z.cols());
  for (const LatentMode& mode : modes_of(system)) {
    const double re = mode.lambda.real(), im = mode.lambda.imag();
    product.row(mode.row) = re * z.row(mode.row);
    if (mode.rows == 1) continue;
    product.row(mode.row) -= im * z.row(mode.row + 1);
    product.row(mode.row + 1) = im * z.row(mode.row) + re * z.row(mode.row + 1);
  }
  return product;
}

}  // namespace nlo::trainer
