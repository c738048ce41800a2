// SPDX-License-Identifier: MIT
// The units of a gated observer (nlo/gated_observer.h) over whole trajectories, eight side by side, and their gradient:
// backpropagation through time, exact for the discrete steps.
//   forward   z_k = z_{k-1} + s (c - z_{k-1}),  [a_s; a_g] = W_g [z_{k-1}; w_k] + b_g,  s by a_s,
//             g = (1 + tanh a_g) / 2,   c = tanh(W_c [g z_{k-1}; w_k] + b_c),   z_{-1} = 0,  w = (y - mean) / scale
//   backward  with p_k = dl/dz_k in all:   da_s = p (c - z) ds/da_s,   da_c = p s (1 - c^2),   q = W_c^T da_c
//             da_g = q z (1 - tanh^2 a_g) / 2,   p_{k-1} = p (1 - s) + q g + W_g^T [da_s; da_g] + dl/dz_{k-1}
// Only z of a run is stored. The backward pass recomputes gates and targets for 32 samples at a time, which fills the
// registers. It computes the weights' gradients likewise. Only W^T da must be computed sample by sample.
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/base/aligned_vector.h"
#include "trainer/gradients/sensitivity/linear_latent.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Eight trajectories; arrays are [row][time][8].
template <class Scalar>
struct GatedRun {
  int length = 0;                     ///< samples
  const Scalar* readings = nullptr;   ///< n_r rows
  Scalar* latent = nullptr;           ///< n_z rows
  const Scalar* cotangent = nullptr;  ///< dl/dz at each sample, n_z rows
  /// [time][8]: length of the step that ends at a sample [sample periods]. Null: all 1.
  const Scalar* periods = nullptr;
  const std::uint8_t* held = nullptr;  ///< n_y rows: 1 where an output was not measured; null: all were
};

/// Readings that depend on the units at earlier samples. They are computed while the units run, and the backward pass
/// returns their gradient to them.
template <class Scalar>
class GatedLoop {
 public:
  virtual ~GatedLoop() = default;

  /// Writes the readings of a sample to the memory of GatedRun::readings.
  virtual void read(int time) = 0;
  /// Called after a step of the units. in: [z; normalised readings], eight values for each row.
  virtual void stepped(int time, const Scalar* in) = 0;
  /// Recomputes the readings of samples [from, from + count). Then pull_back() is called for each of them, from the
  /// last to the first.
  virtual void repeat(int from, int count) = 0;
  /// Adds the gradient through the readings to dl/dz of a sample. `in` is as in stepped().
  virtual void pull_back(int time, const Scalar* in, Scalar* to_z) = 0;
  /// Receives dl/d(normalised readings) of that sample.
  virtual void take(int time, const Scalar* to_readings) = 0;
};

template <class Scalar>
class GatedUnits {
 public:
  /// Parameters: a single layer of 3 n_z rows (s, g, c) over [z; readings], W row by row, then b. After them there may
  /// be `others` that do not belong to the units.
  GatedUnits(int units, const Normalisation& readings, int others = 0);
  GatedUnits(const GatedUnits&) = delete;
  GatedUnits& operator=(const GatedUnits&) = delete;

  int columns() const { return columns_; }
  int parameters() const { return (3 * units_ + others_) * (columns_ + 1); }
  const Scalar* weights(int row) const { return theta_ + row * columns_; }
  const Scalar* bias(int row) const { return theta_ + (3 * units_ + others_) * columns_ + row; }

  /// Reads theta, which must stay in its place until the next prepare().
  void prepare(const Scalar* theta);

  /// Fills run.latent. `loop` makes the readings; null: they exist already.
  void forward(const GatedRun<Scalar>& run, GatedLoop<Scalar>* loop = nullptr);

  /// Adds the gradient of the parameters. It needs run.latent of forward(), run.cotangent and the readings. The
  /// gradient of the other parameters is 0.
  void backward(const GatedRun<Scalar>& run, std::vector<double>& gradient, GatedLoop<Scalar>* loop = nullptr);

 private:
  /// Samples [from, from + count) of a run.
  struct Chunk {
    int from, count;
  };
  void gather_readings(const GatedRun<Scalar>& run, int time);
  template <class Math>
  void pull(const Scalar* in, Scalar* raw_share, Scalar* gate, Scalar* reset_in, Scalar* target) const;
  void repeat(const GatedRun<Scalar>& run, Chunk chunk);
  void pull_back(const GatedRun<Scalar>& run, int time, int column);

  int units_, readings_, columns_, others_;
  std::vector<Scalar> mean_, inverse_scale_;
  const Scalar* theta_ = nullptr;
  AlignedVector<Scalar> by_columns_;  ///< [z; readings] x 3 n_z: column by column of W

  // One sample of eight trajectories.
  AlignedVector<Scalar> in_, gate_, target_, z_;
  AlignedVector<Scalar> p_, to_all_, pulled_, to_readings_;  ///< to_all_: of a_s, a_g, a_c
  // A chunk of samples, side by side.
  AlignedVector<Scalar> chunk_in_, chunk_reset_in_, chunk_raw_, chunk_gate_, chunk_target_;
  AlignedVector<Scalar> chunk_own_, chunk_cotangent_, gradient_;  ///< chunk_own_: dl/dz at each sample
};

}  // namespace nlo::trainer
