// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/map_block.h"

#include <algorithm>

namespace nlo::trainer {

template <class Scalar, int kColumns>
MapBlock<Scalar, kColumns>::MapBlock(const ObserverStructure& structure, bool normalised, bool with_tangents)
    : structure_(&structure),
      normalised_(normalised),
      forward_(*structure.forward_map, with_tangents),
      inverse_(structure.network),
      forward_transposed_(static_cast<std::size_t>(structure.forward_map->parameters)),
      inverse_transposed_(static_cast<std::size_t>(structure.network.parameters)),
      eigenvalue_gradient_(static_cast<std::size_t>(structure.latent.rows)),
      latent_(static_cast<std::size_t>(structure.latent.rows) * kStride),
      latent_cotangent_(latent_.size()) {}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::prepare(const Scalar* inverse_map, const Scalar* forward_map,
                                         const std::vector<double>& eigenvalues) {
  inverse_parameters_ = inverse_map;
  forward_parameters_ = forward_map;
  eigenvalues_ = eigenvalues;
  transpose_weights(structure_->network, inverse_map, inverse_transposed_.data());
  transpose_weights(*structure_->forward_map, forward_map, forward_transposed_.data());
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::clear_gradient() {
  forward_.clear_gradient();
  inverse_.clear_gradient();
  std::fill(eigenvalue_gradient_.begin(), eigenvalue_gradient_.end(), 0.0);
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::gradient(Scalar* inverse_map, Scalar* forward_map, double* eigenvalues) const {
  inverse_.gradient(inverse_map);
  forward_.gradient(forward_map);
  std::copy(eigenvalue_gradient_.begin(), eigenvalue_gradient_.end(), eigenvalues);
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::set_forward_input(const MapSamples<Scalar>& samples) {
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const auto mean = static_cast<Scalar>(structure_->state_mean[i]);
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(structure_->state_scale[i]);
    const Scalar* x = samples.x + i * kStride;
    Scalar* u = forward_.input() + i * kStride;
    for (int s = 0; s < samples.count; ++s) u[s] = (x[s] - mean) * inverse;
    std::fill(u + samples.count, u + kColumns, Scalar(0));
  }
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::forward(const MapSamples<Scalar>& samples) {
  set_forward_input(samples);
  forward_.forward(forward_parameters_);
  for (std::size_t r = 0; r < structure_->latent_scale.size(); ++r) {
    const auto mean = static_cast<Scalar>(structure_->latent_mean[r]),
               scale = static_cast<Scalar>(structure_->latent_scale[r]);
    const Scalar* n = forward_.output() + r * kStride;
    for (int s = 0; s < samples.count; ++s) latent(r)[s] = mean + scale * n[s];
  }
  std::fill(latent_cotangent_.begin(), latent_cotangent_.end(), Scalar(0));
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::backward(int count) {
  for (std::size_t r = 0; r < structure_->latent_scale.size(); ++r) {
    const auto scale = static_cast<Scalar>(structure_->latent_scale[r]);
    const Scalar* from = latent_cotangent(r);
    Scalar* to = forward_.output_cotangent() + r * kStride;
    for (int s = 0; s < count; ++s) to[s] = scale * from[s];
    std::fill(to + count, to + kColumns, Scalar(0));
  }
  forward_.backward(forward_parameters_, forward_transposed_.data());
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::forward_tangents(const MapSamples<Scalar>& samples) {
  set_forward_input(samples);
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const Scalar inverse = Scalar(1) / static_cast<Scalar>(structure_->state_scale[i]);
    const Scalar* f = samples.f + i * kStride;
    Scalar* tangent = forward_.input_tangent() + i * kStride;
    for (int s = 0; s < samples.count; ++s) tangent[s] = f[s] * inverse;
    std::fill(tangent + samples.count, tangent + kColumns, Scalar(0));
  }
  forward_.forward(forward_parameters_);
  forward_.forward_tangents(forward_parameters_);
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::run_inverse(const MapSamples<Scalar>& samples) {
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    const FeatureFormula<Scalar> formula(features[f]);
    const Scalar* z = features[f].latent >= 0 ? latent(static_cast<std::size_t>(features[f].latent)) : nullptr;
    const Scalar* y =
        features[f].reading >= 0 ? samples.y + static_cast<std::ptrdiff_t>(features[f].reading) * kStride : nullptr;
    Scalar* u = inverse_.input() + f * kStride;
    for (int s = 0; s < samples.count; ++s)
      u[s] = formula.normalised(z != nullptr ? z + s : nullptr, y != nullptr ? y + s : nullptr);
    std::fill(u + samples.count, u + kColumns, Scalar(0));
  }
  inverse_.forward(inverse_parameters_);
}

template <class Scalar, int kColumns>
void MapBlock<Scalar, kColumns>::pull_back_inverse(int count) {
  inverse_.backward(inverse_parameters_, inverse_transposed_.data());
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (features[f].latent < 0) continue;
    const Scalar inverse = FeatureFormula<Scalar>(features[f]).inverse;
    const Scalar* du = inverse_.input_cotangent() + f * kStride;
    Scalar* to = latent_cotangent(static_cast<std::size_t>(features[f].latent));
    for (int s = 0; s < count; ++s) to[s] += inverse * du[s];
  }
}

template class MapBlock<float, kBlock>;
template class MapBlock<double, 8>;

}  // namespace nlo::trainer
