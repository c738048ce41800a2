// SPDX-License-Identifier: MIT
// The least time of forward and backward passes of a network on one core: their products and the tanh of the hidden
// values, on blocks that stay in cache, without loss, noise, filter or optimiser. Together with the peak of
// machine_peak.h, training_epoch compares with it.
#pragma once

#include <nlo/kernels/activation.h>
#include <nlo/kernels/simd.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <vector>

#include "trainer/gradients/nn/network_block.h"
#include "trainer/gradients/nn/network_shape.h"

namespace nlo::bench {

/// Products of each layer: one forward and two backward. The gradient of the first layer's inputs is included, because
/// learned eigenvalues need it.
inline constexpr int kPasses = 3;

/// Returns the seconds of one call: the fastest of many bursts, because other programs only make it slower.
template <class Call>
double fastest_seconds(const Call& call, int calls_per_burst, int bursts) {
  call();
  double best = 1e9;
  for (int burst = 0; burst < bursts; ++burst) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls_per_burst; ++i) call();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    best = std::min(best, elapsed.count() / calls_per_burst);
  }
  return best;
}

/// Returns the seconds per sample for the three products of each layer by Eigen: W a forward, dv a^T for the weights'
/// gradient, and W^T dv for the layer below. kOrder says which values of a block are adjacent: the values of one sample
/// (ColMajor) or the values of one neuron (RowMajor).
template <int kOrder>
double eigen_products(const trainer::NetworkShape& shape, int block, int bursts) {
  using Block = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, kOrder>;
  double seconds = 0.0;
  for (const trainer::LayerView& layer : shape.layers) {
    const Eigen::MatrixXf w = Eigen::MatrixXf::Random(layer.out, layer.in);
    const Block a = Block::Random(layer.in, block), dv = Block::Random(layer.out, block);
    Block v(layer.out, block), da(layer.in, block);
    Eigen::MatrixXf dw = Eigen::MatrixXf::Zero(layer.out, layer.in);
    const auto products = [&] {
      v.noalias() = w * a;
      dw.noalias() += dv * a.transpose();
      da.noalias() = w.transpose() * dv;
      asm volatile("" : : "m"(*v.data()), "m"(*dw.data()), "m"(*da.data()) : "memory");
    };
    seconds += fastest_seconds(products, 1 + 20'000 / block, bursts) / block;
  }
  return seconds;
}

/// Returns the seconds of one tanh of the training, over values in the first-level cache.
inline double tanh_seconds(int bursts) {
  constexpr int kCount = 2048;
  using P = simd::Pack<float>;
  std::vector<float> values(kCount, 0.5F);
  const auto all = [&] {
    for (int i = 0; i < kCount; i += simd::kLanes<float>)
      simd::store(values.data() + i, tanh_rational(simd::load<P>(values.data() + i)));
    asm volatile("" : : "m"(*values.data()) : "memory");
  };
  return fastest_seconds(all, 200, bursts) / kCount;
}

/// Returns the seconds per sample of the trainer's own passes over one block again and again, including tanh and its
/// slope.
inline double own_passes(const trainer::NetworkShape& shape, int bursts) {
  trainer::WideBlock block(shape);
  std::vector<float> parameters(static_cast<std::size_t>(shape.parameters), 0.02F), transposed = parameters;
  std::fill_n(block.input(), shape.inputs() * trainer::kRow, 0.5F);
  const auto passes = [&] {
    block.forward(parameters.data());
    std::fill_n(block.output_cotangent(), shape.outputs() * trainer::kRow, 0.1F);
    block.backward(parameters.data(), transposed.data());
  };
  return fastest_seconds(passes, 20, bursts) / trainer::kBlock;
}

/// Times in seconds per sample.
struct TrainingLimit {
  double eigen_products;  ///< with the better layout and the best of several widths of a block
  double tanh;            ///< time of tanh of all hidden values of a sample
  double own_passes;
};

///   bursts  number of bursts for each; the fastest counts
inline TrainingLimit training_limit(const trainer::NetworkShape& shape, int bursts) {
  TrainingLimit limit{.eigen_products = 1e9, .tanh = 0.0, .own_passes = own_passes(shape, bursts)};
  for (const int block : {64, 128, 256, 512, 1024}) {
    limit.eigen_products = std::min({limit.eigen_products, eigen_products<Eigen::ColMajor>(shape, block, bursts),
                                     eigen_products<Eigen::RowMajor>(shape, block, bursts)});
  }
  int hidden = 0;
  for (std::size_t l = 0; l + 1 < shape.layers.size(); ++l) hidden += shape.layers[l].out;
  limit.tanh = hidden * tanh_seconds(bursts);
  return limit;
}

}  // namespace nlo::bench
