// SPDX-License-Identifier: MIT
// An observer with a prior (codegen/model/prior.h) over whole trajectories, eight side by side, and its gradient:
// backpropagation through time, exact for the discrete steps, with exact derivatives of the known equations.
//   back from g = dl/d[x; p]_k, without the parts that the range clamps: through the measurement (covariance_lanes.h),
// with
//   x_k = ... + K s(nu) + b to K g s(nu)' and to b g, to nu and x- through the units' inputs; then through RK4 of
//   [x; p], stage by stage, to dl/d[x; p]_{k-1}
#pragma once

#include <vector>

#include "codegen/model/equations.h"
#include "trainer/structures/covariance_lanes.h"
#include "trainer/structures/equation_lanes.h"
#include "trainer/structures/gated_units.h"

namespace nlo::trainer {

/// Properties of the observer before training.
struct PriorSetting {
  codegen::Equations equations;
  int units = 0, readings = 0, inputs = 0;        ///< n_m, n_r, n_u
  int unestimated = 0;                            ///< the last states of the equations, which T* does not read
  bool commands = false;                          ///< the input of a sample has acted since the one before
  bool noisy = false;                             ///< training adds noise to the sensors
  bool whole_runs = false;                        ///< every segment of the training begins where its run does
  double period_s = 0.0;                          ///< unit of rates
  std::vector<bool> on_circle;                    ///< n_s: the sine or cosine of an angle
  std::vector<double> start, low, high;           ///< the first prior of [x; p], and where it is kept
  std::vector<double> fine, coarse;               ///< n_y, of s(nu)
  std::vector<double> state_noise, output_noise;  ///< n_s, n_y: variances where c is 0
  std::vector<double> scale;                      ///< scale of the correction's outputs
  Normalisation read;                             ///< normalisation of w

  int nx() const { return equations.nx(); }  ///< n_s
  int estimated() const { return nx() - unestimated; }
  int ny() const { return equations.ny(); }
  int reads() const { return 2 * ny() + readings + nx(); }  ///< n_w
  int carried() const { return equations.carried(); }
  int corrections() const { return nx() * (ny() + 2) + ny(); }  ///< [K; b; c_q; c_r]
};

/// GatedRun with z = [m; x; p].
template <class Scalar>
class PriorLanes final : private GatedLoop<Scalar> {
 public:
  explicit PriorLanes(const PriorSetting& setting);

  int parameters() const { return units_.parameters(); }
  void prepare(const Scalar* theta);
  void forward(const GatedRun<Scalar>& run);
  void backward(const GatedRun<Scalar>& run, std::vector<double>& gradient);

 private:
  using L = Lanes<Scalar>;
  /// One piece of the step between two samples, as RK4 takes it.
  struct Piece {
    std::vector<L> stages;
    std::vector<L> reached;  ///< [x; p] before it is kept within the range
  };
  /// How the step to a sample is cut, lane by lane.
  struct Cut {
    L pieces, h;
    int most;
  };
  /// The values of a sample that its pullback reads.
  struct Sample {
    Cut cut;
    std::vector<Piece> pieces;
    std::vector<L> output;  ///< [x-; p-], and the outputs' values behind it
  };

  static constexpr double kFarthestNoise = 16.0;  ///< largest logarithm of a noise's factor

  void begin(const GatedRun<Scalar>& run);
  void make_readings(int time);
  /// [x; p] of sample `time` - 1 becomes the prior of `time`, in place.
  void predict(L* x, int time, Sample& sample);
  void predict_back(const Sample& sample, L* cotangent);
  Cut cut(int time) const;
  L step_of(const Cut& cut, int piece) const;
  void inputs_at(const Cut& cut, int time, int piece, double c, L* u) const;
  void read(int time) override;
  void stepped(int time, const Scalar* in) override;
  void repeat(int from, int count) override;
  void pull_back(int time, const Scalar* in, Scalar* to_z) override;
  void take(int time, const Scalar* to_readings) override;

  void correct(const Scalar* in, int time);
  /// exp(c), c one of the last corrections and kept within +-16.
  L noise(int correction) const;
  void noise_back(int correction, const L& variance, const L& to_variance);
  L periods(int time) const {
    return run_.periods == nullptr || time == 0 ? in_lanes<L>(1.0) : simd::load<L>(run_.periods + time * kGroup);
  }
  /// 1 where output j was measured, else 0.
  L arrived(int j, int time) const;
  Scalar* w(int row, int time) { return w_.data() + (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup; }
  const Scalar* w(int row, int time) const {
    return w_.data() + (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup;
  }
  Scalar* x(int row, int time) const {
    return run_.latent + (static_cast<std::ptrdiff_t>(setting_.units + row) * run_.length + time) * kGroup;
  }
  L reading(int row, int time) const { return simd::load<L>(w(row, time)); }
  /// The sample's place among those that are pulled back together.
  Sample& sample(int time) { return samples_[static_cast<std::size_t>(time - first_sample_)]; }
  /// First row of the prior in w.
  int prior_row() const { return setting_.reads() - setting_.nx(); }
  /// First row of the noises among the corrections.
  int noise_row() const { return setting_.corrections() - setting_.nx() - setting_.ny(); }
  /// Returns whether element i of [x; p] is within its range, lane by lane.
  auto within(L x, int i) const {
    const auto row = static_cast<std::size_t>(i);
    return (x >= in_lanes<L>(setting_.low[row])) & (x <= in_lanes<L>(setting_.high[row]));
  }
  Scalar scale(int r) const { return static_cast<Scalar>(setting_.scale[static_cast<std::size_t>(r)]); }

  PriorSetting setting_;
  GatedUnits<Scalar> units_;
  EquationLanes<Scalar> equations_;
  CovarianceUpdate<Scalar> update_;
  Measured<Scalar> measured_, to_measured_;
  GatedRun<Scalar> run_;
  const Scalar* given_ = nullptr;  ///< readings
  std::vector<Scalar> w_;          ///< w of a run
  std::vector<Sample> samples_;    ///< from first_sample_ on
  int first_sample_ = 0;
  std::vector<L> to_expected_;                 ///< cotangents of the outputs
  std::vector<Scalar> gain_;                   ///< [K; b; c_q; c_r] of a sample
  std::vector<Scalar> correction_transposed_;  ///< columns x corrections
  std::vector<L> x_, to_x_;                    ///< [x; p] behind the correction; dl/d[x; p]
  std::vector<Scalar> unit_;                   ///< unit of [x; p]: a state's deviation
  std::vector<L> to_squashed_;
  std::vector<Scalar> to_gain_, to_in_;
  std::vector<Scalar> gradient_, bias_gradient_;  ///< gradients of the correction, lanes apart
};

}  // namespace nlo::trainer
