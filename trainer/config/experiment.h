// SPDX-License-Identifier: MIT
// One experiment: all settings of a training run, read from a TOML file. All defaults are defined here. Exactly one of
// `plant` (simulate) and `log` (CSV files) is set.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trainer/base/by_type.h"
#include "trainer/base/noise.h"
#include "trainer/config/choices.h"

namespace nlo::trainer {

/// [plant]: a built-in plant by `model`, or expressions over the state names (and the parameters).
struct PlantConfig {
  std::string model;                ///< name in the registry; empty if the plant is given by expressions
  std::vector<std::string> states;  ///< names
  std::vector<std::string> state_units, output_units;  ///< units of a plant by expressions; empty: dimensionless
  std::vector<std::string> derivative;  ///< dx/dt, one expression per state; reads the inputs, too, if there is no
                                        ///< input_field
  std::vector<std::string> output_names;
  std::vector<std::string> outputs;  ///< y = h(x), one expression per output
  bool outputs_read_inputs = false;  ///< the equations only step an observer beside logs, so y = h(x, u)
  /// Full turns of angles, in their units; 0: not an angle. An empty list: no angles.
  std::vector<double> state_wraps, output_wraps;
  std::vector<Encoding> state_encodings, output_encodings;  ///< encodings of angles; empty: unwrapped
  std::vector<std::string> estimated;            ///< the states that the observer estimates, in this order; empty: all
  std::vector<std::string> even;                 ///< states and outputs whose sign does not change in the mirror image
  std::vector<std::string> inputs, input_units;  ///< names; empty: the plant is autonomous
  /// g(x) of dx/dt = f(x) + g(x) u: a row per state with one expression per input
  std::vector<std::vector<std::string>> input_field;
  std::vector<std::pair<std::string, double>> parameters;  ///< nominal values
  /// [low, high] of the parameters that are drawn for each trajectory; the nominal value is the middle.
  std::vector<std::pair<std::string, std::array<double, 2>>> parameter_ranges;
};

/// [simulation]: trajectories of the plant by RK4 at the sample period.
struct SimulationConfig {
  double horizon_s = 50.0;
  double sample_period_s = 0.02;
  int trajectories = 50;
  InitialDistribution initial_distribution = InitialDistribution::kUniform;
  std::vector<double> initial_low, initial_high;    ///< the training box, n_x each; a state with equal limits is fixed
  std::vector<double> initial_centre;               ///< c of the circle, n_x; empty: the origin
  std::vector<std::vector<double>> initial_axes;    ///< its half axes a and b, n_x each: an ellipse in any plane
  std::vector<std::vector<double>> initial_states;  ///< the initial states of a list, n_x each
  std::vector<double> process_noise;                ///< n_x, standard deviation per sqrt(s); empty: none
  double process_noise_share = 1.0;  ///< share of the runs that have process noise, see has_process_noise
  // For simulated runs that are added to logs in training:
  NoiseConfig noise;    ///< noise of their sensors, drawn once for each run; logs contain their own noise
  double share = 0.35;  ///< share of the segments of a step

  /// Returns true if run `run` of a simulated set has process noise. Among any N consecutive runs, about
  /// process_noise_share * N runs have it, with a difference of at most four. The pattern has no period, so it is
  /// independent of noises that alternate between runs.
  bool has_process_noise(std::uint64_t run) const {
    // Multiples of the golden ratio fill [0, 1) more evenly than random numbers (Weyl 1916).
    const double turns = 0.6180339887498949 * static_cast<double>(run);
    return !process_noise.empty() && turns - std::floor(turns) < process_noise_share;
  }
};

/// [excitation]: the inputs of simulated trajectories, drawn for each trajectory and input (plants/drawn_inputs.h).
struct ExcitationConfig {
  std::vector<InputSignal> kinds = {InputSignal::kConstant, InputSignal::kSteps,  InputSignal::kPrbs,
                                    InputSignal::kSine,     InputSignal::kSquare, InputSignal::kMultisine,
                                    InputSignal::kChirp,    InputSignal::kNoise};
  std::vector<double> low, high;             ///< range of each input, n_u
  std::vector<double> amplitude;             ///< amplitudes of oscillations, [least, most]; empty: up to half the range
  double shortest_s = 0.0, longest_s = 0.0;  ///< limits of holds and periods; 0: derived, see hold_times()
  std::string log;                           ///< CSV file of recorded inputs, of the kind "log"
  std::vector<std::string> log_columns;      ///< columns of that file, one for each input
  std::string log_time;                      ///< its column of time [s]; empty: rows are a sample period apart
};

/// [feedback]: runs in closed loop, u = sat(k(x_hat, r)) (plants/state_feedback.h).
struct FeedbackConfig {
  std::vector<std::string> law;                     ///< k, one expression for each input
  std::vector<double> actuator_low, actuator_high;  ///< limits to which u is clipped, n_u
  double share = 1.0;                               ///< share of the runs in closed loop
  std::vector<double> error;                        ///< n_x, deviation of x_hat - x in round 0; empty: none
  int rounds = 0;    ///< number of rounds after round 0; each uses the observer of the last round
  std::string cost;  ///< expression of a sample's cost; empty: none
};

/// [[log.columns]]: one column of a CSV log, or a state derived from one.
struct ColumnConfig {
  std::string name;    ///< name here, in the report and in the exported header
  std::string column;  ///< heading of the column in the file; default: `name`
  ColumnRole role = ColumnRole::kIgnored;
  std::string unit;       ///< unit of the values in the observer
  std::string file_unit;  ///< unit of the cells, if it differs; empty: `unit`
  double scale = 1.0;     ///< value = scale * cell + offset, in file_unit
  double offset = 0.0;    ///< added to every value, in file_unit
  double wrap = 0.0;      ///< full turn of an angle, in its unit; 0: not an angle
  Encoding encoding = Encoding::kUnwrap;
  std::vector<std::string> missing;  ///< numbers and words in its cells that mean no value, in addition to those of
                                     ///< [log]
  std::string derivative_of;  ///< name of the column of which this state is the derivative (see VelocityFilterConfig)
  std::string expression;     ///< expression of a computed output, by names of outputs and inputs; empty: a column
  bool odd = true;          ///< the mirror image changes its sign; false: it does not (a temperature, a forward speed)
  double delay_s = 0.0;     ///< delay of an input [s]: it acts this much later than logged
  double period_s = 0.0;    ///< period of an output that is slower than the rows; 0: measured in every row
  bool find_delay = false;  ///< delay_s = "estimate": the delay is found in the training logs (data/log_delays.h)
};

/// [log.velocity_filter]: Butterworth low-pass run forwards and backwards, then a central difference.
struct VelocityFilterConfig {
  int order = 4;
  double cutoff_hz = 25.0;
  double mask_edges_s = 0.2;  ///< truth this close to an end of a log has no weight
};

struct LogConfig {
  std::vector<ColumnConfig> columns;
  std::string separator = ",";       ///< between cells: "," ";" "tab" "space"
  std::string decimal = ".";         ///< decimal mark of numbers: "." ","
  std::vector<std::string> missing;  ///< numbers and words in cells that mean no value, in addition to the usual words
  VelocityFilterConfig velocity_filter;
  double sample_period_s = 0.0;  ///< nominal; 0: taken from the time stamps
  int every = 1;                 ///< the observer gets each n-th row; sample_period_s is the period of these rows
  double max_gap_s = 0.0;        ///< a longer step splits a log into runs; 0: 10 nominal periods
  std::vector<std::string> train_files, validation_files, test_files;  ///< names or globs under --data DIR
};

/// [observer]: the latent system and the readings of T*.
struct ObserverConfig {
  std::string structure = "kkl";             ///< a name in the table of structures/structure_table.h
  std::vector<double> eigenvalues;           ///< real ones [1/s], all negative; repeated for each output
  std::vector<std::array<double, 2>> pairs;  ///< complex pairs re +- i im [1/s]; repeated for each output
  bool learn_eigenvalues = true;
  Injection output_injection = Injection::kOnes;
  Hold hold = Hold::kFirstOrder;
  LatentStart start = LatentStart::kZero;
  std::vector<double> clocks_s;  ///< time constants of latent rows exp(-t/tau), which tell T* the time since a reset
  FeatureSet features = FeatureSet::kLatent;  ///< angles need kLatentMinusOutput
  /// Hold of known inputs: the given u has acted since the last sample, or it is interpolated like the outputs.
  Hold input_hold = Hold::kZeroOrder;

  ByType own;  ///< keys of one structure alone, in a struct of its module
};

/// [dynamics]: the network within the latent system, which is g_hat of (15) or F of (11).
struct DynamicsConfig {
  std::vector<int> hidden = {16};
  std::string activation = "tanh";
};

/// [forward_map]: T, if the structure or a loss needs it.
struct ForwardMapConfig {
  std::vector<int> hidden = {50, 50, 50, 50};
  std::string activation = "tanh";
};

/// [loss]: the cost (9) as a weighted sum of the terms that learn/losses/loss_registry.h lists.
struct LossConfig {
  std::map<std::string, double, std::less<>> weights = {{"state_error", 1.0}};  ///< by name; 0 if a term is not named
  Reduction reduction = Reduction::kMean;
  EquationPoints collocation = EquationPoints::kData;
  std::vector<double> collocation_low, collocation_high;  ///< the box of the points, n_x each
  int collocation_points = 2048;
  ErrorScale scale = ErrorScale::kPhysical;

  double weight(std::string_view term) const {
    const auto found = weights.find(term);
    return found == weights.end() ? 0.0 : found->second;
  }
  bool is_normalised() const { return scale == ErrorScale::kNormalised; }
};

/// [inverse_map]: T*.
struct InverseMapConfig {
  std::vector<int> hidden = {50, 50, 50, 50};
  std::string activation = "tanh";  ///< tanh, relu, silu
  bool linear_path = false;         ///< a linear map beside the network, started from ridge regression
  double ridge = 1e-6;              ///< regularisation of the linear path, relative to the features' mean power
  bool error = false;               ///< T* also gives the standard deviation of each state's error
  ReadoutChoice readout = ReadoutChoice::kSelected;
  bool fallback = false;  ///< states may fall back to a linear row (codegen::Fallback) if that helps on left-out logs
};

/// [training]
struct TrainingConfig {
  TrainingMode mode = TrainingMode::kRandomSamples;
  int steps = 1000;                ///< optimiser steps (in full_batch mode: epochs)
  int trajectories_per_step = 32;  ///< random_samples: number of segments per step
  int samples_per_step = 4096;     ///< random_samples: number of samples per step at which T* is evaluated
  double segment_s = 0.0;          ///< length of a random segment; 0: whole trajectories from their start
  double first_segment_s = 0.0;    ///< > 0: length in the first step; it grows to segment_s in the first half of the
                                   ///< steps
  double first_share = 0.0;        ///< share of the random segments that begin at the first sample of a run
  double early_s = 0.0, early_share = 0.0;  ///< share of the samples with t < early_s
  std::string optimiser = "adam";           ///< name in learn/optim/optimiser.h
  double learning_rate = 1e-3;
  double eigenvalue_learning_rate = 0.0;  ///< 0: the same as learning_rate
  std::string schedule = "cosine";        ///< schedule of both rates, a name in learn/optim/optimiser.h
  double decay = 0.9999;                  ///< factor of the exponential schedule per step
  double gradient_clip = 0.0;             ///< > 0: a longer gradient is scaled to this length
  double weight_decay = 0.0;              ///< decay of T*'s network weights (decoupled, as in AdamW)
  double ema = 0.0;   ///< weight averaging: the model is the exponential average of the weights; 0: off
  NoiseConfig noise;  ///< added to the outputs, drawn again in each step
  std::vector<NoiseConfig> noise_mixture;  ///< used instead of `noise`: the noises alternate between trajectories
  NoiseConfig input_noise;       ///< noise of the inputs that the observer reads; the plant gets them without noise
  double noise_level_max = 0.0;  ///< > 0: the noise of each trajectory is scaled by a number uniform in [0, max]
  double dropout = 0.3;          ///< share of the segments in which a sensor that may fail is missing
  bool mirror = false;           ///< segments are mirrored at random (data/mirror.h)
  LatentGradient gradient = LatentGradient::kAutomatic;
  Transient transient = Transient::kKeep;
  double transient_factor = 5.0;  ///< k; the transient lasts k / min |Re lambda| seconds
  /// Returns the noise that is added to the outputs.
  NoiseMixture all_noise() const { return noise_mixture.empty() ? NoiseMixture(noise) : NoiseMixture(noise_mixture); }
  int validate_every = 100;  ///< steps between validation errors (progress, metrics.csv)
  double checkpoint_every_s = 10.0;
};

/// [validation]: trainings that leave out some of the training logs measure the errors on unseen logs. These errors
/// choose the readouts that ship (choose/left_out.h).
struct ValidationConfig {
  std::string groups;  ///< regular expression: logs in whose names it finds the same text are left out together; empty:
                       ///< each log by itself
  /// Number of trainings that leave out logs. Each has half of the training steps, and exactly one of them leaves out
  /// a given group of logs. 0: no training leaves out logs, and the training logs choose the readouts.
  int folds = 4;
};

/// A window of time since the start of a run, from_s <= t < to_s, over which errors are averaged.
struct EvaluationWindow {
  std::string name;  ///< an identifier; the window "all" is the whole run and always exists
  double from_s = 0.0;
  double to_s = std::numeric_limits<double>::infinity();  ///< infinite: to the end of the run
};

/// [evaluation]: times that the evaluation of an observer uses. They do not affect training. Keys that are left out are
/// derived from the slowest time constant of the observer and the horizon (data/evaluation_windows.h).
struct EvaluationConfig {
  std::vector<EvaluationWindow> windows;
  double settling_window_s = 0.0;  ///< time over which errors are averaged for the settling time; 0: derived
};

/// [plant] beside [log]: known equations of the rig (experiments/known_plant.h).
struct KnownPlant {
  PlantConfig plant;
  SimulationConfig simulation;
  std::optional<ExcitationConfig> excitation;
};

struct Experiment {
  std::string name;  ///< an identifier: name of the model and of the export
  unsigned long long seed = 1;
  int threads = 0;  ///< 0: all cores. The bytes of a run do not depend on it.
  std::optional<PlantConfig> plant;
  SimulationConfig simulation;
  std::optional<ExcitationConfig> excitation;  ///< none: a plant's inputs stay at 0
  std::optional<FeedbackConfig> feedback;      ///< empty: no closed loop
  std::optional<LogConfig> log;
  std::optional<KnownPlant> known;  ///< known plant for an experiment with logs; then `plant` is empty
  ObserverConfig observer;
  DynamicsConfig dynamics;
  InverseMapConfig inverse_map;
  ForwardMapConfig forward_map;
  LossConfig loss;
  TrainingConfig training;
  ValidationConfig validation;
  EvaluationConfig evaluation;

  /// Returns true if the inputs of the plant are not zero.
  bool moves_inputs() const { return excitation.has_value() || feedback.has_value(); }

  std::string source_text;  ///< the text of format_experiment(), recorded in the model; reading it gives the
                            ///< same experiment
};

}  // namespace nlo::trainer
