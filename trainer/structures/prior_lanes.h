// SPDX-License-Identifier: MIT
// An observer with a prior (codegen/model/prior.h) over whole trajectories, eight side by side, and its gradient:
// backpropagation through time, exact for the discrete steps, with exact derivatives of the known equations. The
// backward pass propagates g = dl/d[x; p]_k, which is 0 for elements that the range clamps, in three stages:
//   - through the measurement update (covariance_lanes.h)
//   - through x_k = ... + K s(nu) + b: g s(nu)' is the cotangent of K, g that of b; the inputs of the units give the
//     cotangents of nu and x-
//   - through RK4 of [x; p], stage by stage, to dl/d[x; p]_{k-1}
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
  int units = 0, readings = 0, inputs = 0;   ///< numbers of units (n_m), readings (n_r) and inputs (n_u)
  int unestimated = 0;                       ///< number of states that T* does not read; they are the last ones
  bool commands = false;                     ///< true: the input of a sample has acted since the previous sample
  bool noisy = false;                        ///< true: training adds noise to the sensors
  bool whole_runs = false;                   ///< true: every segment of the training begins with its run
  double period_s = 0.0;                     ///< unit of rates
  std::vector<bool> on_circle;               ///< true: the state is the sine or cosine of an angle; n_s
  std::vector<codegen::Interval> start_box;  ///< ranges of the unestimated states at a start; unless runs have them
  std::vector<double> start, low, high;      ///< [x; p]: initial prior and limits
  std::vector<double> fine, coarse;          ///< arguments c of s(nu, c), n_y
  std::vector<double> state_noise, output_noise;  ///< variances without a correction, n_s and n_y
  std::vector<double> scale;                      ///< scale of the correction's outputs
  Normalisation read;                             ///< normalisation of w

  int nx() const { return equations.nx(); }  ///< n_s
  int estimated() const { return nx() - unestimated; }
  int ny() const { return equations.ny(); }
  int reads() const { return 2 * ny() + readings + nx(); }  ///< n_w
  int carried() const { return equations.carried(); }
  int corrections() const { return units > 0 ? nx() * (ny() + 2) + ny() : 0; }  ///< [K; b; c_q; c_r]
};

/// Runs a GatedRun with z = [m; x; p].
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
  /// One step of RK4. A longer step between two samples is cut into several pieces.
  struct Piece {
    std::vector<L> stages;
    std::vector<L> reached;  ///< [x; p] before it is clamped to the range
  };
  /// The pieces of the step that ends at a sample, for each lane: their number, and their length [s]. `most`: largest
  /// number.
  struct Cut {
    L pieces, h;
    int most;
  };
  /// The values of a sample that its backward pass reads.
  struct Sample {
    Cut cut;
    std::vector<Piece> pieces;
    std::vector<L> output;  ///< [x-; p-], then the values of the outputs
  };

  static constexpr double kFarthestNoise = 16.0;  ///< largest |c| in exp(c)

  void begin(const GatedRun<Scalar>& run);
  void make_readings(int time);
  /// Advances [x; p], in place, from sample `time` - 1 to the prior of sample `time`.
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
  /// Returns exp(c), where c is one of the last corrections, clamped to +-16; 1 without units.
  L noise(int correction) const;
  void noise_back(int correction, const L& variance, const L& to_variance);
  L periods(int time) const {
    return run_.periods == nullptr || time == 0 ? in_lanes<L>(1.0) : simd::load<L>(run_.periods + time * kGroup);
  }
  /// Returns 1 for lanes in which output j was measured, else 0.
  L arrived(int j, int time) const;
  Scalar* w(int row, int time) { return w_.data() + (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup; }
  const Scalar* w(int row, int time) const {
    return w_.data() + (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup;
  }
  Scalar* x(int row, int time) const {
    return run_.latent + (static_cast<std::ptrdiff_t>(setting_.units + row) * run_.length + time) * kGroup;
  }
  L reading(int row, int time) const { return simd::load<L>(w(row, time)); }
  /// Returns the stored values of a sample. Those of a chunk of samples are stored together for the backward pass.
  Sample& sample(int time) { return samples_[static_cast<std::size_t>(time - first_sample_)]; }
  /// Returns the first row of the prior in w.
  int prior_row() const { return setting_.reads() - setting_.nx(); }
  /// Returns the first row of the noises (c_q, c_r) among the corrections.
  int noise_row() const { return setting_.corrections() - setting_.nx() - setting_.ny(); }
  /// Returns a mask of the lanes in which element i of [x; p] is within its range.
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
  std::vector<Scalar> w_;          ///< w at all samples of the run
  std::vector<Sample> samples_;    ///< samples of the chunk that starts at first_sample_
  int first_sample_ = 0;
  std::vector<L> to_expected_;                 ///< cotangents of the outputs h(x-)
  std::vector<Scalar> gain_;                   ///< [K; b; c_q; c_r] of a sample
  std::vector<Scalar> correction_transposed_;  ///< columns x corrections
  std::vector<L> x_, to_x_;                    ///< x_: [x; p] after the correction; to_x_: dl/d[x; p]
  std::vector<Scalar> unit_;                   ///< units of [x; p]: deviations of the states
  std::vector<L> to_squashed_;
  std::vector<Scalar> to_gain_, to_in_;
  std::vector<Scalar> gradient_, bias_gradient_;  ///< gradients of the correction's W and b, one for each lane
};

}  // namespace nlo::trainer
