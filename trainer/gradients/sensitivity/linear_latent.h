// SPDX-License-Identifier: MIT
// The latent system of a KKL observer over whole trajectories, and its adjoint. With linear dynamics and a y that does
// not depend on z, the forward pass is a filter, and the gradient with respect to the eigenvalues is the same filter
// run backwards: (13)-(14) with F linear in z, for the discrete recurrence and therefore exact.
//   forward   z_{k+1} = a z_k + b0 y_k + b1 y_{k+1}
//   adjoint   p_k = conj(a) p_{k+1} + dl/dz_k
//   gradient  dl/dlambda = sum_k conj(p_{k+1}) (a' z_k + b0' y_k + b1' y_{k+1}) + conj(p_0) s' y_0
#pragma once

#include <complex>
#include <cstddef>
#include <limits>
#include <vector>

#include "nlo/latent.h"
#include "trainer/config/choices.h"

namespace nlo::trainer {

/// Number of trajectories that are filtered side by side.
inline constexpr int kGroup = 8;

/// One mode of D: a real eigenvalue (one latent row) or a complex pair (two rows), driven by one reading; or a clock.
struct Mode {
  bool pair = false;
  int row = 0;       ///< its first latent row
  int reading = -1;  ///< index of the reading that drives it; -1: a clock, exp(lambda t) with initial value 1
};

struct LatentShape {
  std::vector<Mode> modes;  ///< pairs, then real ones, then clocks
  int rows = 0;             ///< n_z
  int learned = 0;          ///< number of rows whose eigenvalue is a parameter: all rows except clocks
  Hold hold = Hold::kFirstOrder;
  Injection injection = Injection::kOnes;
  bool starts_steady = false;
  /// Readings from this index on are commands: the value of a sample has acted since the last sample.
  int commands_from = std::numeric_limits<int>::max();

  /// Returns 1 if the reading at the start of a step is that of the next sample (a command), else 0.
  int ahead(int reading) const { return reading >= commands_from ? 1 : 0; }
};

/// Computes eigenvalues from unconstrained parameters, row by row: re = -exp(p), im = exp(p). They are always stable.
void eigenvalues_from_parameters(const LatentShape& shape, const float* parameters, double* eigenvalues);
std::vector<float> parameters_from_eigenvalues(const LatentShape& shape, const double* eigenvalues);

/// Returns the entry f of F for a mode, and the steady gain s = -f / lambda, as complex numbers.
std::complex<double> injection_of(Injection injection, const Mode& mode, std::complex<double> lambda);

/// Coefficients of a step and their derivatives with respect to lambda; they include F.
struct ModeCoefficients {
  std::complex<float> a_minus_1, b0, b1;
  std::complex<float> da, db0, db1;
};

/// Coefficients of all modes for a set of steps: one for uniform sampling, else the distinct steps of a log.
class Coefficients {
 public:
  /// steps_s: the distinct steps [s].
  void compute(const LatentShape& shape, const double* eigenvalues, const std::vector<double>& steps_s);
  const ModeCoefficients* mode(std::size_t m) const { return table_.data() + m * steps_; }
  std::complex<float> start(std::size_t m) const { return start_[m]; }              ///< s
  std::complex<float> start_slope(std::size_t m) const { return start_slope_[m]; }  ///< ds/dlambda

 private:
  std::size_t steps_ = 0;
  std::vector<ModeCoefficients> table_;
  std::vector<std::complex<float>> start_, start_slope_;
};

/// Up to eight segments of equal length, side by side. Arrays are [row][time][lane].
struct SegmentGroup {
  int length = 0;                  ///< samples
  int lanes = 0;                   ///< segments in use; the others repeat the last
  std::vector<float> readings;     ///< n_r x length x 8, noise included
  std::vector<std::uint8_t> held;  ///< n_y x length x 8: 1 if an output was not measured; empty: all were measured
  std::vector<float> latent;       ///< n_z x length x 8
  std::vector<float> cotangent;    ///< dl/dz, n_z x length x 8
  std::vector<int> step_of;  ///< length x 8: index of the step after a sample in the coefficients; empty if sampling is
                             ///< uniform (all 0)
  std::vector<double> gradient;  ///< dl/d(parameters), n learned rows
  bool continues = false;        ///< `latent` holds z of sample 0: the group continues longer segments

  /// Marks output `row` as not measured at place `i` of its row, time * 8 + lane. `outputs`: n_y.
  void hold(int outputs, int row, std::size_t i) {
    held.resize(at(outputs, 0), 0);
    held[at(row, 0) + i] = 1;
  }

  std::size_t at(int row, int time) const {
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(length) + static_cast<std::size_t>(time)) * kGroup;
  }
};

/// Fills group.latent from group.readings.
void filter(const LatentShape& shape, const Coefficients& coefficients, SegmentGroup& group);

/// Fills group.gradient from group.cotangent.
void adjoint_filter(const LatentShape& shape, const Coefficients& coefficients, const double* eigenvalues,
                    SegmentGroup& group);

}  // namespace nlo::trainer
