// SPDX-License-Identifier: MIT
// An observer with a prior (codegen/model/prior.h) over whole trajectories, eight side by side, and its gradient:
// backpropagation through time, exact for the discrete steps, with exact derivatives of the known equations.
//   back from dl/dx_k = p, less what the range of x cuts off, with x_k = x-_k + K s(nu) + b:
//   to K p s(nu)',  to b p,  to nu and x- by K' p and by what the units read;  dl/dx_{k-1} += (df/dx)' dl/dx-_k
#pragma once

#include <vector>

#include "codegen/model/equations.h"
#include "trainer/structures/gated_units.h"

namespace nlo::trainer {

/// What is known of the observer before training.
struct PriorSetting {
  codegen::Equations equations;
  int units = 0, readings = 0, inputs = 0;  ///< n_m, n_r, n_u
  bool commands = false;                    ///< the input of a sample has acted since the one before
  double period_s = 0.0;                    ///< what rates are told in
  std::vector<bool> on_circle;              ///< n_x: the sine or cosine of an angle
  std::vector<double> start, low, high;     ///< n_x: the first prior, and where x is kept
  std::vector<double> fine, coarse;         ///< n_y, of s(nu)
  std::vector<double> scale;                ///< n_x (n_y + 1): of the correction's outputs
  Normalisation read;                       ///< of w

  int nx() const { return equations.nx(); }
  int ny() const { return equations.ny(); }
  int reads() const { return 2 * ny() + readings + nx(); }  ///< n_w
  int corrections() const { return nx() * (ny() + 1); }
};

/// GatedRun with z = [m; x].
template <class Scalar>
class PriorLanes final : private GatedLoop<Scalar> {
 public:
  explicit PriorLanes(const PriorSetting& setting);

  int parameters() const { return units_.parameters(); }
  void prepare(const Scalar* theta);
  void forward(const GatedRun<Scalar>& run);
  void backward(const GatedRun<Scalar>& run, std::vector<double>& gradient);

 private:
  void begin(const GatedRun<Scalar>& run);
  /// x of sample `time` - 1 becomes the prior of `time`. Value: of eight lanes, or with their derivative.
  template <class Value>
  void predict(Value* x, int time) const;
  void read(int time) override;
  void stepped(int time, const Scalar* in) override;
  void pull_back(int time, const Scalar* in, Scalar* to_z) override;
  void take(int time, const Scalar* to_readings) override;

  void correct(const Scalar* in, int time);
  Scalar* w(int row, int time) { return w_.data() + (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup; }
  Scalar* x(int row, int time) const {
    return run_.latent + (static_cast<std::ptrdiff_t>(setting_.units + row) * run_.length + time) * kGroup;
  }
  int prior_row() const { return setting_.reads() - setting_.nx(); }  ///< of w
  Scalar low(int i) const { return static_cast<Scalar>(setting_.low[static_cast<std::size_t>(i)]); }
  Scalar high(int i) const { return static_cast<Scalar>(setting_.high[static_cast<std::size_t>(i)]); }
  Scalar scale(int r) const { return static_cast<Scalar>(setting_.scale[static_cast<std::size_t>(r)]); }

  PriorSetting setting_;
  GatedUnits<Scalar> units_;
  GatedRun<Scalar> run_;
  const Scalar* given_ = nullptr;              ///< readings
  std::vector<Scalar> w_;                      ///< of a run
  std::vector<Scalar> gain_;                   ///< [K; b] of a sample
  std::vector<Scalar> correction_transposed_;  ///< columns x corrections
  std::vector<Scalar> p_, x_, to_prior_, to_squashed_, to_gain_, to_in_;
  std::vector<Scalar> gradient_, bias_gradient_;  ///< of the correction, lanes apart
};

}  // namespace nlo::trainer
