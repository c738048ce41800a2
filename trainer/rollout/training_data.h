// SPDX-License-Identifier: MIT
// A dataset in the format of the training, and the segments of its runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "trainer/base/noise.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// A dataset in the format of the training: float32, one row per channel, and a list of the distinct steps between
/// samples.
struct TrainingData {
  /// Points of a box with their f and h, row by row, at which the PDE residual (5) is required in addition to the data.
  struct Points {
    int count = 0;
    std::vector<float> x, f, h;
  };
  struct Run {
    int samples = 0;
    int first_estimate = 0;    ///< see Trajectory
    std::vector<int> step_of;  ///< for each sample the index in steps_s of the next step; empty if sampling is uniform
    std::vector<float> readings;     ///< n_r x samples: outputs, then the inputs that the observer reads
    std::vector<std::uint8_t> held;  ///< n_y x samples: 1 if an output was not measured; empty: all were measured
    std::vector<float> states;       ///< n_x x samples
    std::vector<float> unestimated;  ///< rows x samples, see Trajectory
    std::vector<float> weight;       ///< samples
    std::vector<float> derivatives;  ///< n_x x samples, f(x); only for the PDE residual
  };
  struct Sensor {
    std::size_t index = 0;
    int row = 0, rows = 1;  ///< row in the readings; an angle as sine and cosine is one sensor with two rows
    double wrap = 0.0;      ///< full turn of such an angle
  };
  std::vector<Run> runs;
  std::size_t logged = 0;  ///< number of runs from logs; the following runs are simulated and get the share
                           ///< `simulated_share` of a step's segments
  double simulated_share = 0.0;
  Points collocation;
  std::vector<Sensor> sensors;  ///< sensors of outputs, then of inputs; computed outputs have no sensor
  /// One entry if sampling is uniform; otherwise the distinct steps, rounded to 1/16384 of a period. Coefficients are
  /// computed once for each. A log of 20,000 samples whose clock jitters by 1 % has some hundred of them.
  std::vector<double> steps_s;
  double sample_period_s = 0.0;  ///< nominal
  bool uniform = true;
  int nx = 0, ny = 0, nr = 0;
  codegen::ComputedOutputs computed;  ///< computed outputs, the last of the outputs; computed during the roll-out
  codegen::SensorFailures failures;   ///< their stalenesses are the last readings; computed during the roll-out
  std::vector<float> fading;          ///< exp(-step / staleness_s) of each of steps_s
  std::vector<int> missed;            ///< number of missed samples in each of steps_s, as in flight
  std::vector<int> not_due;  ///< for each of failures.outputs: samples after an arrival in which it is not due (fold.h)
  std::vector<float> reading_low, reading_high;  ///< range of given readings and their mirror images, without noise;
                                                 ///< infinite for angles
  Mirror mirror;

  explicit TrainingData(const Dataset& dataset, const codegen::SensorFailures& failures = {});

  bool is_computed(int output) const { return !computed.none() && output >= computed.first(); }
  int given() const { return nr - static_cast<int>(failures.outputs.size()); }  ///< number of readings in the data
};

/// Limits to which flight and training clamp each given reading. They are infinite unless a noise of the sensor has
/// tails. Then they are the reading's range, widened on each side by the width of the range plus six times the largest
/// scale of these noises.
struct ReadingLimits {
  std::vector<float> low, high;
  ReadingLimits() = default;
  ReadingLimits(const TrainingData& data, const NoiseMixture& noise, const NoiseConfig& input_noise);
};

/// Samples [from, to) of a segment at which a sensor is missing.
struct Outage {
  int from = 0, to = 0;
};

struct Segment {
  int run = 0;
  int start = 0;
  int length = 0;
  bool mirrored = false;             ///< its readings and states are those of the mirror image (TrainingData::mirror)
  float noise_level = 1.0F;          ///< factor of the configured noise
  std::vector<Outage> outages = {};  ///< one for each sensor that may fail; empty: no outage
};

/// Longest run [samples] that is rolled out as one segment. Longer runs are split. All eight lanes of a group have
/// the length of its longest segment, so a single run of millions of samples would need eight times its memory.
inline constexpr int kLongestWhole = 1 << 18;  ///< samples

/// Returns all runs from their start, at full length. A run longer than kLongestWhole becomes eight segments of equal
/// length.
std::vector<Segment> whole_runs(const TrainingData& data);

/// Returns whole runs with one sensor missing throughout, for each sensor that may fail. Empty if `dropout` is 0,
/// because then no step trains such runs.
std::vector<Segment> runs_with_failures(const TrainingData& data, double dropout);

}  // namespace nlo::trainer
