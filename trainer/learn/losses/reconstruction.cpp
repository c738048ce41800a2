// SPDX-License-Identifier: MIT
#include <algorithm>

#include "trainer/learn/losses/map_terms.h"
#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {

template <class Scalar, int kColumns>
double reconstruction(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                      Scalar* cotangent_z) {
  constexpr int kStride = MapBlock<Scalar, kColumns>::kStride;
  block.run_inverse(samples);
  double loss = 0.0;
  for (std::size_t i = 0; i < block.structure().state_scale.size(); ++i) {
    const auto mean = static_cast<Scalar>(block.structure().state_mean[i]),
               scale = static_cast<Scalar>(block.structure().state_scale[i]);
    const Scalar share = static_cast<Scalar>(weight) * block.state_share(i);
    const Scalar* n = block.inverse_network().output() + i * kStride;
    const Scalar* x = samples.x + i * kStride;
    Scalar* cotangent = block.inverse_network().output_cotangent() + i * kStride;
    Scalar sum(0);
    for (int s = 0; s < samples.count; ++s) {
      const Scalar error = mean + scale * n[s] - x[s];
      sum += share * samples.weight[s] * error * error;
      cotangent[s] = Scalar(2) * share * samples.weight[s] * error * scale;
    }
    std::fill(cotangent + samples.count, cotangent + kColumns, Scalar(0));
    loss += static_cast<double>(sum);
  }
  if (cotangent_z != nullptr) block.pull_back_inverse(samples.count);
  return loss;
}

template double reconstruction(MapBlock<double, 8>&, const MapSamples<double>&, double, double*);

LossTerm reconstruction_loss() {
  return {.name = "reconstruction",
          .meaning = "weight of |x - T*(T(x))|^2",
          .needs_forward_map = true,
          .needs_eigenvalues = true,
          .form = MapLoss{reconstruction<float, kBlock>}};
}

}  // namespace nlo::trainer
