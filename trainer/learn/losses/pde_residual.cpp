// SPDX-License-Identifier: MIT
#include <algorithm>
#include <complex>

#include "trainer/learn/losses/map_terms.h"
#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {

template <class Scalar, int kColumns>
double pde_residual(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                    bool backward) {
  constexpr std::ptrdiff_t kStride = MapBlock<Scalar, kColumns>::kStride;
  block.forward_tangents(samples);
  auto& network = block.tangent_network();
  const auto mean_of = [&](int row) {
    return static_cast<Scalar>(block.structure().latent_mean[static_cast<std::size_t>(row)]);
  };
  const auto scale_of = [&](int row) {
    return static_cast<Scalar>(block.structure().latent_scale[static_cast<std::size_t>(row)]);
  };
  const auto factor = static_cast<Scalar>(weight);
  const bool unit_gain = block.structure().latent.injection == Injection::kUnitGain;
  double loss = 0.0;
  for (const Mode& mode : block.structure().latent.modes) {
    const auto row = static_cast<std::size_t>(mode.row);
    const std::complex<double> lambda{block.eigenvalues()[row], mode.pair ? block.eigenvalues()[row + 1] : 0.0};
    const std::complex<double> injection = injection_of(block.structure().latent.injection, mode, lambda);
    const auto re = static_cast<Scalar>(lambda.real()), im = static_cast<Scalar>(lambda.imag());
    const auto f_re = static_cast<Scalar>(injection.real()), f_im = static_cast<Scalar>(injection.imag());
    const Scalar* h = samples.h + static_cast<std::ptrdiff_t>(mode.reading) * kStride;
    const Scalar* n = network.output() + mode.row * kStride;
    const Scalar* n_dot = network.output_tangent() + mode.row * kStride;
    Scalar* pull = network.output_cotangent() + mode.row * kStride;
    Scalar* pull_dot = network.output_tangent_cotangent() + mode.row * kStride;
    const Scalar share = factor * block.latent_share(row), scale = scale_of(mode.row);
    const Scalar share_im = mode.pair ? factor * block.latent_share(row + 1) : Scalar(0);
    const Scalar scale_im = mode.pair ? scale_of(mode.row + 1) : Scalar(0);
    Scalar sum(0), slope_re(0), slope_im(0);
    for (int s = 0; s < samples.count; ++s) {
      const Scalar w = samples.weight[s];
      const Scalar t = mean_of(mode.row) + scale * n[s];
      const Scalar t_im = mode.pair ? mean_of(mode.row + 1) + scale_im * n[s + kStride] : Scalar(0);
      const Scalar r = scale * n_dot[s] - (re * t - im * t_im) - f_re * h[s];
      const Scalar rho = Scalar(2) * share * w * r;
      sum += share * w * r * r;
      const Scalar driven = unit_gain ? h[s] : Scalar(0);  // F = -lambda: -dF/dlambda h
      slope_re += rho * (driven - t);
      pull_dot[s] = scale * rho;
      pull[s] = -scale * re * rho;
      if (!mode.pair) continue;
      const Scalar r_im = scale_im * n_dot[s + kStride] - (im * t + re * t_im) - f_im * h[s];
      const Scalar rho_im = Scalar(2) * share_im * w * r_im;
      sum += share_im * w * r_im * r_im;
      slope_re -= rho_im * t_im;
      slope_im += rho * t_im + rho_im * (driven - t);
      pull[s] -= scale * im * rho_im;
      pull[s + kStride] = scale_im * (im * rho - re * rho_im);
      pull_dot[s + kStride] = scale_im * rho_im;
    }
    loss += static_cast<double>(sum);
    block.eigenvalue_gradient(row) += backward ? static_cast<double>(slope_re) : 0.0;
    if (mode.pair) block.eigenvalue_gradient(row + 1) += backward ? static_cast<double>(slope_im) : 0.0;
    for (int r = 0; r < (mode.pair ? 2 : 1); ++r) {
      std::fill(pull + r * kStride + samples.count, pull + r * kStride + kColumns, Scalar(0));
      std::fill(pull_dot + r * kStride + samples.count, pull_dot + r * kStride + kColumns, Scalar(0));
    }
  }
  if (backward) block.backward_tangents();
  return loss;
}

template double pde_residual(MapBlock<double, 8>&, const MapSamples<double>&, double, bool);

LossTerm pde_residual_loss() {
  return {.name = "pde_residual",
          .meaning = "weight of |dT/dx f(x) - D T(x) - F h(x)|^2 (5)",
          .needs_forward_map = true,
          .needs_eigenvalues = true,
          .needs_equations = true,
          .form = EquationLoss{pde_residual<float, kBlock>}};
}

}  // namespace nlo::trainer
