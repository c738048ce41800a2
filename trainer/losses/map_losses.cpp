// SPDX-License-Identifier: MIT
#include "trainer/losses/map_losses.h"

#include <algorithm>
#include <complex>

namespace nlo::trainer {

template <class Scalar, int kColumns>
MapLosses<Scalar, kColumns>::MapLosses(const ObserverStructure& structure, const LossConfig& config)
    : structure_(&structure),
      config_(&config),
      forward_(*structure.forward_map, config.pde_residual > 0.0),
      inverse_(structure.network),
      forward_transposed_(static_cast<std::size_t>(structure.forward_map->parameters)),
      inverse_transposed_(static_cast<std::size_t>(structure.network.parameters)),
      eigenvalue_gradient_(static_cast<std::size_t>(structure.latent.rows)),
      latent_(static_cast<std::size_t>(structure.latent.rows) * Block::kStride),
      latent_cotangent_(latent_.size()) {}

template <class Scalar, int kColumns>
void MapLosses<Scalar, kColumns>::prepare(const Scalar* inverse_map, const Scalar* forward_map,
                                          const std::vector<double>& eigenvalues) {
  inverse_parameters_ = inverse_map;
  forward_parameters_ = forward_map;
  eigenvalues_ = eigenvalues;
  transpose_weights(structure_->network, inverse_map, inverse_transposed_.data());
  transpose_weights(*structure_->forward_map, forward_map, forward_transposed_.data());
}

template <class Scalar, int kColumns>
void MapLosses<Scalar, kColumns>::clear_gradient() {
  forward_.clear_gradient();
  inverse_.clear_gradient();
  std::fill(eigenvalue_gradient_.begin(), eigenvalue_gradient_.end(), 0.0);
}

template <class Scalar, int kColumns>
void MapLosses<Scalar, kColumns>::gradient(Scalar* inverse_map, Scalar* forward_map, double* eigenvalues) const {
  inverse_.gradient(inverse_map);
  forward_.gradient(forward_map);
  std::copy(eigenvalue_gradient_.begin(), eigenvalue_gradient_.end(), eigenvalues);
}

/// Share of a squared error in z: of its own unit, or of its deviation.
template <class Scalar, int kColumns>
Scalar MapLosses<Scalar, kColumns>::latent_share(std::size_t row) const {
  const auto scale = static_cast<Scalar>(structure_->latent_scale[row]);
  return config_->scale == "normalised" ? Scalar(1) / (scale * scale) : Scalar(1);
}

template <class Scalar, int kColumns>
void MapLosses<Scalar, kColumns>::set_forward_input(const MapSamples<Scalar>& samples) {
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const auto mean = static_cast<Scalar>(structure_->state_mean[i]);
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(structure_->state_scale[i]);
    const Scalar* x = samples.x + i * Block::kStride;
    Scalar* u = forward_.input() + i * Block::kStride;
    for (int s = 0; s < samples.count; ++s) u[s] = (x[s] - mean) * inverse;
    std::fill(u + samples.count, u + kColumns, Scalar(0));
  }
}

template <class Scalar, int kColumns>
double MapLosses<Scalar, kColumns>::consistency(const MapSamples<Scalar>& samples, Scalar* cotangent_z) {
  const bool backward = cotangent_z != nullptr;
  set_forward_input(samples);
  forward_.forward(forward_parameters_);
  const std::size_t nz = structure_->latent_scale.size();
  const auto weight = static_cast<Scalar>(config_->map_consistency);
  double loss = 0.0;
  for (std::size_t r = 0; r < nz; ++r) {
    const auto mean = static_cast<Scalar>(structure_->latent_mean[r]),
               scale = static_cast<Scalar>(structure_->latent_scale[r]);
    const Scalar share = weight * latent_share(r);
    const Scalar* n = forward_.output() + r * Block::kStride;
    const Scalar* z = samples.z + r * Block::kStride;
    Scalar* map = latent_.data() + r * Block::kStride;
    Scalar* cotangent = latent_cotangent_.data() + r * Block::kStride;
    Scalar sum(0);
    for (int s = 0; s < samples.count; ++s) {
      map[s] = mean + scale * n[s];
      const Scalar error = map[s] - z[s];
      sum += share * samples.weight[s] * error * error;
      cotangent[s] = Scalar(2) * share * samples.weight[s] * error;
      if (backward) cotangent_z[r * Block::kStride + static_cast<std::size_t>(s)] -= cotangent[s];
    }
    loss += static_cast<double>(sum);
  }
  if (config_->reconstruction > 0.0) loss += reconstruct(samples, backward);
  if (!backward) return loss;
  for (std::size_t r = 0; r < nz; ++r) {
    const auto scale = static_cast<Scalar>(structure_->latent_scale[r]);
    const Scalar* from = latent_cotangent_.data() + r * Block::kStride;
    Scalar* to = forward_.output_cotangent() + r * Block::kStride;
    for (int s = 0; s < samples.count; ++s) to[s] = scale * from[s];
    std::fill(to + samples.count, to + kColumns, Scalar(0));
  }
  forward_.backward(forward_parameters_, forward_transposed_.data());
  return loss;
}

/// |x - T*(T(x))|^2 from latent_; adds dl/dT to latent_cotangent_.
template <class Scalar, int kColumns>
double MapLosses<Scalar, kColumns>::reconstruct(const MapSamples<Scalar>& samples, bool backward) {
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    const auto mean = static_cast<Scalar>(feature.mean), gain = static_cast<Scalar>(feature.output_gain);
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(feature.scale);
    Scalar* u = inverse_.input() + f * Block::kStride;
    for (int s = 0; s < kColumns; ++s) {
      Scalar value = -mean;
      if (feature.latent >= 0) value += latent_[static_cast<std::size_t>(feature.latent * Block::kStride + s)];
      if (feature.output >= 0) value += gain * samples.y[feature.output * Block::kStride + s];
      u[s] = s < samples.count ? value * inverse : Scalar(0);
    }
  }
  inverse_.forward(inverse_parameters_);
  double loss = 0.0;
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const auto mean = static_cast<Scalar>(structure_->state_mean[i]),
               scale = static_cast<Scalar>(structure_->state_scale[i]);
    const Scalar share = static_cast<Scalar>(config_->reconstruction) *
                         (config_->scale == "normalised" ? Scalar(1) / (scale * scale) : Scalar(1));
    const Scalar* n = inverse_.output() + i * Block::kStride;
    const Scalar* x = samples.x + i * Block::kStride;
    Scalar* cotangent = inverse_.output_cotangent() + i * Block::kStride;
    Scalar sum(0);
    for (int s = 0; s < samples.count; ++s) {
      const Scalar error = mean + scale * n[s] - x[s];
      sum += share * samples.weight[s] * error * error;
      cotangent[s] = Scalar(2) * share * samples.weight[s] * error * scale;
    }
    std::fill(cotangent + samples.count, cotangent + kColumns, Scalar(0));
    loss += static_cast<double>(sum);
  }
  if (!backward) return loss;
  inverse_.backward(inverse_parameters_, inverse_transposed_.data());
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (features[f].latent < 0) continue;
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(features[f].scale);
    const Scalar* du = inverse_.input_cotangent() + f * Block::kStride;
    Scalar* to = latent_cotangent_.data() + static_cast<std::ptrdiff_t>(features[f].latent) * Block::kStride;
    for (int s = 0; s < samples.count; ++s) to[s] += inverse * du[s];
  }
  return loss;
}

template <class Scalar, int kColumns>
double MapLosses<Scalar, kColumns>::residual(const MapSamples<Scalar>& samples, bool backward) {
  constexpr std::ptrdiff_t kStride = Block::kStride;
  set_forward_input(samples);
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(structure_->state_scale[i]);
    const Scalar* f = samples.f + i * Block::kStride;
    Scalar* tangent = forward_.input_tangent() + i * Block::kStride;
    for (int s = 0; s < samples.count; ++s) tangent[s] = f[s] * inverse;
    std::fill(tangent + samples.count, tangent + kColumns, Scalar(0));
  }
  forward_.forward(forward_parameters_);
  forward_.forward_tangents(forward_parameters_);
  const auto mean_of = [&](int row) {
    return static_cast<Scalar>(structure_->latent_mean[static_cast<std::size_t>(row)]);
  };
  const auto scale_of = [&](int row) {
    return static_cast<Scalar>(structure_->latent_scale[static_cast<std::size_t>(row)]);
  };
  const auto weight = static_cast<Scalar>(config_->pde_residual);
  const bool unit_gain = structure_->latent.injection == Injection::kUnitGain;
  double loss = 0.0;
  for (const Mode& mode : structure_->latent.modes) {
    const auto row = static_cast<std::size_t>(mode.row);
    const std::complex<double> lambda{eigenvalues_[row], mode.pair ? eigenvalues_[row + 1] : 0.0};
    const std::complex<double> injection = injection_of(structure_->latent.injection, mode, lambda);
    const auto re = static_cast<Scalar>(lambda.real()), im = static_cast<Scalar>(lambda.imag());
    const auto f_re = static_cast<Scalar>(injection.real()), f_im = static_cast<Scalar>(injection.imag());
    const Scalar* h = samples.h + static_cast<std::ptrdiff_t>(mode.output) * kStride;
    const Scalar* n = forward_.output() + mode.row * kStride;
    const Scalar* n_dot = forward_.output_tangent() + mode.row * kStride;
    Scalar* pull = forward_.output_cotangent() + mode.row * kStride;
    Scalar* pull_dot = forward_.output_tangent_cotangent() + mode.row * kStride;
    const Scalar share = weight * latent_share(row), scale = scale_of(mode.row);
    const Scalar share_im = mode.pair ? weight * latent_share(row + 1) : Scalar(0);
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
    eigenvalue_gradient_[row] += backward ? static_cast<double>(slope_re) : 0.0;
    if (mode.pair) eigenvalue_gradient_[row + 1] += backward ? static_cast<double>(slope_im) : 0.0;
    for (int r = 0; r < (mode.pair ? 2 : 1); ++r) {
      std::fill(pull + r * kStride + samples.count, pull + r * kStride + kColumns, Scalar(0));
      std::fill(pull_dot + r * kStride + samples.count, pull_dot + r * kStride + kColumns, Scalar(0));
    }
  }
  if (backward) forward_.backward_tangents(forward_parameters_, forward_transposed_.data());
  return loss;
}

template class MapLosses<float, kBlock>;
template class MapLosses<double, 8>;

}  // namespace nlo::trainer
