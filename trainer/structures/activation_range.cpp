// SPDX-License-Identifier: MIT
#include "trainer/structures/activation_range.h"

#include <algorithm>
#include <vector>

#include "trainer/structures/for_each_sample.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

class LargestActivations {
 public:
  explicit LargestActivations(const codegen::Network& map) : map_(map), largest_(map.layers.size() - 1, 0.0) {}

  const std::vector<double>& values() const { return largest_; }

  /// `in`: n_in x B.
  void add(const MatrixXd& in) {
    MatrixXd a = ((map_.features * in).colwise() - map_.feature_mean).array().colwise() / map_.feature_scale.array();
    for (std::size_t l = 0; l < largest_.size(); ++l) {
      a = ((map_.layers[l].weights * a).colwise() + map_.layers[l].bias).eval();
      if (map_.activation == "relu") {
        a = a.cwiseMax(0.0);
      } else {  // silu
        a = (a.array() / (1.0 + (-a.array()).exp())).matrix().eval();
      }
      largest_[l] = std::max(largest_[l], a.cwiseAbs().maxCoeff());
    }
  }

 private:
  const codegen::Network& map_;
  std::vector<double> largest_;
};

}  // namespace

void record_largest_activations(codegen::Model& model, const Rollout& rollout) {
  const codegen::Network& map = model.inverse_map;
  if (map.layers.size() < 2 || map.activation == "tanh") return;

  constexpr long kMost = 1 << 18;
  constexpr Index kBlock = 512;
  long samples = 0;
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup&, int, int) { ++samples; });
  const long stride = (samples + kMost - 1) / kMost;

  LargestActivations largest(map);
  MatrixXd block(map.inputs(), kBlock);  // [z; y], or z
  Index filled = 0;
  long visited = 0;
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
    if (visited++ % stride != 0) return;
    for (Index i = 0; i < block.rows(); ++i) {
      const bool is_latent = i < model.nz();
      const std::vector<float>& signal = is_latent ? group.latent : group.outputs;
      const Index row = is_latent ? i : i - model.nz();
      block(i, filled) =
          static_cast<double>(signal[group.at(static_cast<int>(row), time) + static_cast<std::size_t>(lane)]);
    }
    if (++filled < kBlock) return;
    largest.add(block);
    filled = 0;
  });
  if (filled > 0) largest.add(block.leftCols(filled));
  model.inverse_map.largest_activations = largest.values();
}

}  // namespace nlo::trainer
