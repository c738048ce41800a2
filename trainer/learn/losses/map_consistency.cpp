// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/map_terms.h"
#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {

template <class Scalar, int kColumns>
double map_consistency(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                       Scalar* cotangent_z) {
  constexpr int kStride = MapBlock<Scalar, kColumns>::kStride;
  double loss = 0.0;
  for (std::size_t r = 0; r < block.structure().latent_scale.size(); ++r) {
    const Scalar share = static_cast<Scalar>(weight) * block.latent_share(r);
    const Scalar* z = samples.z + r * kStride;
    const Scalar* map = block.latent(r);
    Scalar* cotangent = block.latent_cotangent(r);
    Scalar* pull_z = cotangent_z != nullptr ? cotangent_z + r * kStride : nullptr;
    Scalar sum(0);
    for (int s = 0; s < samples.count; ++s) {
      const Scalar error = map[s] - z[s];
      sum += share * samples.weight[s] * error * error;
      const Scalar pull = Scalar(2) * share * samples.weight[s] * error;
      cotangent[s] += pull;
      if (pull_z != nullptr) pull_z[s] -= pull;
    }
    loss += static_cast<double>(sum);
  }
  return loss;
}

template double map_consistency(MapBlock<double, 8>&, const MapSamples<double>&, double, double*);

LossTerm map_consistency_loss() {
  return {.name = "map_consistency",
          .meaning = "weight of |z - T(x)|^2",
          .needs_forward_map = true,
          .needs_eigenvalues = true,
          .form = MapLoss{map_consistency<float, kBlock>}};
}

}  // namespace nlo::trainer
