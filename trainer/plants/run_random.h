// SPDX-License-Identifier: MIT
// Random numbers of one simulated run, and the functions that its signals need. They use only additions,
// multiplications, divisions and square roots in double, each rounded once, so that they have the same bits on every
// machine (libraries differ in the last bit of exp, log and sin).
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace nlo::trainer {

/// Returns sin(2 pi t) with an error of 4e-16, for |t| < 2^51.
double sine_of_turns(double t);

/// Returns ln x for finite x > 0, with a relative error of 4e-16 (absolute near 1).
double portable_log(double x);

/// Returns e^x for |x| < 700, with a relative error of 1e-15.
double portable_exp(double x);

/// The purposes for which a run draws random numbers. Their streams are independent (base/random.h has other seeds).
enum class RunPurpose : std::uint64_t {
  kInputs = 1,
  kParameters,
  kProcessNoise,
  kLoggedInputs,
  kParticles,
  kEstimateError
};

/// The stream (engine seed, purpose, part, run). Different runs, and different inputs of a run, never share numbers.
///   engine_seed  initial_state_seed(seed, stream)
///   part         index of an input; 0 if a run has one stream
class RunRandom {
 public:
  RunRandom(std::uint64_t engine_seed, RunPurpose purpose, std::uint64_t part, std::uint64_t run);

  double uniform();                             ///< in [0, 1), 53 bits
  double between(double low, double high);      ///< uniform in [low, high]
  double log_between(double low, double high);  ///< its logarithm is uniform; 0 < low <= high
  double normal();                              ///< standard normal, Marsaglia's polar method, one of each pair
  std::size_t index(std::size_t count);         ///< 0 ... count - 1

 private:
  std::mt19937_64 engine_;  // its numbers are fixed by the C++ standard
};

}  // namespace nlo::trainer
