// SPDX-License-Identifier: MIT
#include "trainer/experiments/section_keys.h"

#include <fmt/format.h>

#include "codegen/model/activations.h"
#include "trainer/base/number_text.h"
#include "trainer/config/value.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/optim/optimiser.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

/// Keys of a section that only configures a network.
template <class Section>
std::vector<Key<Section>> network_keys() {
  return {
      key("hidden", &Section::hidden, between(1, 4096), "widths of the hidden layers"),
      key("activation", &Section::activation, one_of(codegen::activation_names()), "activation of the hidden layers"),
  };
}

/// A key that records of older experiments do not have.
template <class Section>
Key<Section> only_when_given(Key<Section> key) {
  key.only_when_given = true;
  return key;
}

/// Numbers and words that mean "no value". A text that reads as a number counts as that number.
template <class Section>
Key<Section> missing_key(std::string meaning) {
  return only_when_given<Section>({"missing", "[number or text, ...]", std::move(meaning),
                                   [](Section& section, const Toml& value, const std::string& where) {
                                     std::vector<std::string> cells;
                                     for (const Toml& each : list_of(value, where, any())) {
                                       const std::string at = fmt::format("{}[{}]", where, cells.size());
                                       std::string text;
                                       if (each.is_string()) {
                                         read_value(each, at, any(), text);
                                       } else {
                                         double number = 0.0;
                                         read_value(each, at, any(), number);
                                         text = shortest_text(number);
                                       }
                                       cells.push_back(std::move(text));
                                     }
                                     section.missing = std::move(cells);
                                   },
                                   [](const Section& section) { return show_cells(section.missing); }});
}

/// A full turn for each state or output.
Key<PlantConfig> wraps_key(std::string name, std::vector<double> PlantConfig::*field, std::string meaning) {
  return {
      std::move(name), "[number >= 0, \"2pi\" or \"360deg\", ...]", std::move(meaning),
      [=](PlantConfig& plant, const Toml& value, const std::string& where) { read_wraps(value, where, plant.*field); },
      [=](const PlantConfig& plant) { return show_value(plant.*field); }};
}

/// Fixed numbers, and ranges from which each run draws its own value.
Key<PlantConfig> parameters_key() {
  return {
      "parameters", "{ NAME = number or [low, high], ... }",
      "parameters of the expressions or of the built-in plant; a parameter with a range is drawn for each trajectory",
      [](PlantConfig& plant, const Toml& value, const std::string& where) {
        read_parameters(value, where, plant.parameters, plant.parameter_ranges);
      },
      [](const PlantConfig& plant) { return show_parameters(plant.parameters, plant.parameter_ranges); }};
}

/// Keys of [observer] that every structure has. The others are in the module of each structure.
std::vector<Key<ObserverConfig>> common_observer_keys() {
  using O = ObserverConfig;
  return {
      key("structure", &O::structure, one_of(structure_names()), "equations of the observer"),
      key("eigenvalues", &O::eigenvalues, negative(),
          "real eigenvalues of D [1/s], repeated for each output and input"),
      key("pairs", &O::pairs, any(),
          "complex eigenvalues [re, im] of D [1/s], re < 0 < im, repeated for each output and input"),
      key("learn_eigenvalues", &O::learn_eigenvalues, any(), "true: training changes the eigenvalues"),
      key("output_injection", &O::output_injection, names_of<Injection>(),
          "entries of F; ones: 1; unit_gain: -lambda, so that z settles at y"),
      key("hold", &O::hold, names_of<Hold>(), "course of y between samples"),
      key("start", &O::start, names_of<LatentStart>(), "z(0); steady: the steady state of the first output"),
      key("clocks_s", &O::clocks_s, positive(),
          "time constants tau of further inputs exp(-t / tau) of T* [s], which show the time since the start"),
      key("features", &O::features, names_of<FeatureSet>(),
          "readings of T*: z; z and y; z - y and y (necessary for angles)"),
      key("input_hold", &O::input_hold, one_of({"zero_order", "first_order"}),
          "course of known inputs: zero_order: the given u has acted since the last sample; first_order: u is "
          "interpolated like y"),
  };
}

/// The weight of a loss: [loss] TERM.
Key<LossConfig> weight_key(const LossTerm& term) {
  const Rule rule = at_least(0);
  const std::string name(term.name);
  return {name, type_of(0.0) + " " + rule.in_words(), std::string(term.meaning),
          [=](LossConfig& loss, const Toml& value, const std::string& where) {
            read_value(value, where, rule, loss.weights[name]);
          },
          [=](const LossConfig& loss) { return show_value(loss.weight(name)); }};
}

}  // namespace

template <>
const std::vector<Key<Experiment>>& keys() {
  using E = Experiment;
  static const std::vector<Key<E>> kKeys = {
      key("name", &E::name, identifiers(), "name of the model and its exports"),
      key("seed", &E::seed, at_least(0), "seed of the initial states, the weights, the noise and the samples"),
      key("threads", &E::threads, between(0, 1024),
          "number of threads; 0: all cores; the bytes of a run do not depend on it"),
  };
  return kKeys;
}

template <>
const std::vector<Key<PlantConfig>>& keys() {
  using P = PlantConfig;
  static const std::vector<Key<P>> kKeys = {
      key("model", &P::model, any(), "name of a built-in plant; leave it out if you give equations"),
      key("states", &P::states, identifiers(), "names of the states"),
      key("state_units", &P::state_units, any(), "units of the states, one for each"),
      key("derivative", &P::derivative, any(), "dx/dt, an expression for each state over states, parameters, inputs"),
      key("output_names", &P::output_names, identifiers(), "names of the outputs; if not given: y, or y1, y2, ..."),
      key("output_units", &P::output_units, any(), "units of the outputs, one for each"),
      key("outputs", &P::outputs, any(), "y = h(x), an expression for each output"),
      wraps_key("state_wraps", &P::state_wraps, "full turns of angles in their units, one for each state; 0: no angle"),
      wraps_key("output_wraps", &P::output_wraps,
                "full turns of angles in their units, one for each output; 0: no angle"),
      key("state_encodings", &P::state_encodings, names_of<Encoding>(),
          "encodings of angles, one for each state; sincos: two channels NAME_sin and NAME_cos"),
      key("output_encodings", &P::output_encodings, names_of<Encoding>(),
          "encodings of angles, one for each output; sincos: two channels NAME_sin and NAME_cos"),
      key("estimated", &P::estimated, identifiers(), "names of the states to estimate; if not given: all"),
      key("even", &P::even, identifiers(),
          "names of the states, outputs and inputs that keep their sign in the mirror image"),
      key("inputs", &P::inputs, identifiers(), "names of the inputs u; they are 0 without [excitation]"),
      key("input_units", &P::input_units, any(), "units of the inputs, one for each"),
      key("input_field", &P::input_field, any(),
          "g(x) of dx/dt = f(x) + g(x) u: an expression for each state and input; leave it out if derivative uses the "
          "inputs"),
      parameters_key(),
  };
  return kKeys;
}

template <>
const std::vector<Key<SimulationConfig>>& keys() {
  using S = SimulationConfig;
  static const std::vector<Key<S>> kKeys = {
      key("horizon_s", &S::horizon_s, positive(), "length of a trajectory [s]"),
      key("sample_period_s", &S::sample_period_s, positive(),
          "sample period of the observer and of the simulation (RK4) [s]"),
      key("trajectories", &S::trajectories, between(1, 1e6), "number of simulated trajectories for the training"),
      key("initial_distribution", &S::initial_distribution, names_of<InitialDistribution>(),
          "distribution of initial states: uniform over the box; gaussian about its centre, with its half widths as "
          "standard deviations; circle: see initial_axes; list: see initial_states"),
      key("initial_low", &S::initial_low, any(), "lower corner of the training box, one number for each state"),
      key("initial_high", &S::initial_high, any(),
          "upper corner of the training box; a state with equal limits starts there"),
      key("initial_centre", &S::initial_centre, any(),
          "circle: centre, one number for each state; if not given: the origin"),
      key("initial_axes", &S::initial_axes, any(), "circle: two half axes, each with one number for each state"),
      key("initial_states", &S::initial_states, any(), "list: initial states, each used equally often"),
      key("process_noise", &S::process_noise, at_least(0),
          "standard deviation of white noise on dx/dt per sqrt(s), one for each state; if not given: none"),
      only_when_given(key("process_noise_share", &S::process_noise_share, between(0, 1),
                          "share of the runs that have process_noise; the other runs have none")),
      only_when_given(key("noise", &S::noise, any(),
                          "with [log]: noise of the sensors of simulated runs; a list: one for each output")),
      only_when_given(key("share", &S::share, share_below_one(),
                          "with [log]: share of the segments of a step that come from simulated runs")),
  };
  return kKeys;
}

template <>
const std::vector<Key<LogConfig>>& keys() {
  using L = LogConfig;
  static const std::vector<Key<L>> kKeys = {
      key("sample_period_s", &L::sample_period_s, at_least(0),
          "nominal sample period [s]; 0: taken from the time stamps"),
      only_when_given(key(
          "every", &L::every, between(1, 1000),
          "the observer gets every n-th row; sample_period_s is the period of these rows; velocities are computed from "
          "all rows")),
      only_when_given<L>({"separator", "\",\", \";\", \"tab\" or \"space\"",
                          "separator between the cells of a row; space: any number of spaces",
                          [](L& log, const Toml& value, const std::string& where) {
                            if (value.is_string() && value.as_string().str == "\t")
                              log.separator = "tab";
                            else
                              read_value(value, where, one_of({",", ";", "tab", "space"}), log.separator);
                          },
                          [](const L& log) { return show_value(log.separator); }}),
      only_when_given(key("decimal", &L::decimal, one_of({".", ","}), "decimal mark of numbers")),
      missing_key<L>("numbers and words in cells of any column that mean \"no value\": [-9999, \"ERR\"]"),
      key("max_gap_s", &L::max_gap_s, at_least(0),
          "a longer step splits a log into separate runs [s]; 0: 10 nominal periods"),
      key("train_files", &L::train_files, any(), "files or globs (*, ?) of CSV files under --data DIR"),
      key("validation_files", &L::validation_files, any(),
          "files or globs for validation: errors during training and the choice of the model"),
      key("test_files", &L::test_files, any(), "the same, for the report; training never uses them"),
  };
  return kKeys;
}

template <>
const std::vector<Key<ColumnConfig>>& keys() {
  using C = ColumnConfig;
  static const std::vector<Key<C>> kKeys = {
      key("name", &C::name, identifiers(), "name in reports and in the exported header"),
      key("column", &C::column, any(), "heading of the column in the file; if not given: name"),
      key("role", &C::role, names_of<ColumnRole>(), "role of the column"),
      key("unit", &C::unit, any(), "unit of the observer's values: \"rad/s\"; for the time: s, ms, us or ns"),
      only_when_given(
          key("file_unit", &C::file_unit, any(),
              "unit of the cells, if it is another one of the same kind (cm for m, deg for rad); cells are converted")),
      only_when_given(key("scale", &C::scale, any(), "value = scale * cell + offset, before the conversion of units")),
      only_when_given(key("offset", &C::offset, any(), "see scale")),
      missing_key<C>("numbers and words in its cells that mean \"no value\", in addition to those of [log]: [-9999]"),
      {"wrap", "number >= 0, \"2pi\" or \"360deg\"", "full turn of an angle in its unit; 0: not an angle",
       [](C& c, const Toml& value, const std::string& where) { read_wrap(value, where, c.wrap); },
       [](const C& c) { return show_value(c.wrap); }},
      key("encoding", &C::encoding, names_of<Encoding>(),
          "encoding of an angle; sincos: two channels NAME_sin and NAME_cos"),
      key("derivative_of", &C::derivative_of, any(), "name of the column of which this state is the derivative"),
      only_when_given(key("expression", &C::expression, any(),
                          "expression of an output that is computed from other outputs and inputs, also in flight: "
                          "\"speed * rate\"; it may have + - *, powers up to 4, and numbers")),
      only_when_given(
          key("period_s", &C::period_s, at_least(0),
              "period of an output that is slower than the rows [s]: between its samples its last value is held, "
              "and the status in flight is kOk")),
      key("odd", &C::odd, any(),
          "true: the column changes its sign in the mirror image; false (a temperature, a forward speed): it does not"),
      only_when_given<C>(
          {"delay_s", "number >= 0, or \"estimate\"",
           "delay of an input [s]: it acts on the plant this much later than logged; estimate: found in the training "
           "logs",
           [](C& c, const Toml& value, const std::string& where) { read_delay(value, where, c.delay_s, c.find_delay); },
           [](const C& c) { return c.find_delay ? show_value(std::string("estimate")) : show_value(c.delay_s); }}),
  };
  return kKeys;
}

template <>
const std::vector<Key<VelocityFilterConfig>>& keys() {
  using V = VelocityFilterConfig;
  static const std::vector<Key<V>> kKeys = {
      key("order", &V::order, between(1, 8), "order of the Butterworth low-pass, which runs forward and backward"),
      key("cutoff_hz", &V::cutoff_hz, positive(), "cut-off frequency of the low-pass [Hz]"),
      key("mask_edges_s", &V::mask_edges_s, at_least(0), "truth this close to an end of a log does not count [s]"),
  };
  return kKeys;
}

template <>
const std::vector<Key<ObserverConfig>>& keys() {
  static const std::vector<Key<ObserverConfig>> kKeys = [] {
    std::vector<Key<ObserverConfig>> all = common_observer_keys();
    for (const TrainableStructure* structure : structure_table())
      for (Key<ObserverConfig>& own : structure->own_keys())
        if (!has_key(all, own.name)) all.push_back(std::move(own));  // structures may share a key
    return all;
  }();
  return kKeys;
}

template <>
const std::vector<Key<InverseMapConfig>>& keys() {
  using I = InverseMapConfig;
  static const std::vector<Key<I>> kKeys = {
      key("hidden", &I::hidden, Rule{.low = 1, .high = 1024, .at_most = 16}, "widths of the hidden layers of T*"),
      key("activation", &I::activation, one_of(codegen::activation_names()), "activation of the hidden layers"),
      key("linear_path", &I::linear_path, any(),
          "true: adds a linear map to the network, which starts as a ridge regression"),
      key("ridge", &I::ridge, at_least(0),
          "regularisation of the linear map, relative to the mean power of the features"),
      only_when_given(key("error", &I::error, any(),
                          "true: T* also gives the standard deviation of each state's error, calibrated on validation "
                          "runs")),
      only_when_given(
          key("readout", &I::readout, names_of<ReadoutChoice>(),
              "readout in the model; selected: for each state the network, a linear row or a blend of both, "
              "whichever is best on validation data; settled: the same, by the error after the transient; "
              "network: T* as trained")),
      only_when_given(key("fallback", &I::fallback, any(),
                          "true: where T* is far from a linear row, a state falls back to the row, if this lowers the "
                          "errors on left-out logs by at least 5 %; false: never")),
  };
  return kKeys;
}

template <>
const std::vector<Key<DynamicsConfig>>& keys() {
  static const auto kKeys = network_keys<DynamicsConfig>();
  return kKeys;
}

template <>
const std::vector<Key<ForwardMapConfig>>& keys() {
  static const auto kKeys = network_keys<ForwardMapConfig>();
  return kKeys;
}

template <>
const std::vector<Key<LossConfig>>& keys() {
  using L = LossConfig;
  static const std::vector<Key<L>> kKeys = [] {
    std::vector<Key<L>> all;
    for (const LossTerm& term : loss_terms()) all.push_back(weight_key(term));
    // Models record their experiment with the keys in this order: reduction comes after the first weight.
    all.insert(
        all.begin() + 1,
        key("reduction", &L::reduction, names_of<Reduction>(),
            "reduction of running costs over time; integral: the mean times the horizon; logarithm: the mean logarithm "
            "over groups of eight runs, so that runs with little noise count as much as others"));
    all.insert(
        all.end(),
        {key("collocation", &L::collocation, names_of<EquationPoints>(), "points at which equation (5) is required"),
         key("collocation_low", &L::collocation_low, any(), "lower corner of the box, one number for each state"),
         key("collocation_high", &L::collocation_high, any(), "upper corner of the box"),
         key("collocation_points", &L::collocation_points, between(1, 1e7), "number of points drawn from the box"),
         key("scale", &L::scale, names_of<ErrorScale>(),
             "physical: squared errors in the units of x and z; normalised: divided by their deviation")});
    return all;
  }();
  return kKeys;
}

template <>
const std::vector<Key<TrainingConfig>>& keys() {
  using T = TrainingConfig;
  static const std::vector<Key<T>> kKeys = {
      key("mode", &T::mode, names_of<TrainingMode>(), "samples of one step"),
      key("steps", &T::steps, between(0, 1e8),
          "optimiser steps (full_batch: epochs); 0: T* stays the ridge regression of linear_path"),
      key("trajectories_per_step", &T::trajectories_per_step, between(1, 1e6),
          "random_samples: number of segments in a step"),
      key("samples_per_step", &T::samples_per_step, between(1, 1e8),
          "random_samples: number of samples in a step at which T* is evaluated"),
      key("segment_s", &T::segment_s, at_least(0), "length of the random segments [s]; 0: whole trajectories"),
      only_when_given(
          key("first_segment_s", &T::first_segment_s, at_least(0),
              "length of the segments in the first step [s]; it grows to segment_s in the first half of the "
              "steps; 0: segment_s in all steps")),
      only_when_given(key("first_share", &T::first_share, between(0, 1),
                          "share of the segments that begin at the first sample of a run; the others begin anywhere")),
      key("early_s", &T::early_s, at_least(0), "time for early_share [s]"),
      key("early_share", &T::early_share, share_below_one(), "share of the samples with t < early_s"),
      key("optimiser", &T::optimiser, one_of(optimiser_names()), "gradient method"),
      key("learning_rate", &T::learning_rate, positive(), "learning rate of the weights"),
      key("eigenvalue_learning_rate", &T::eigenvalue_learning_rate, at_least(0),
          "learning rate of the eigenvalues; 0: the same as learning_rate"),
      key("schedule", &T::schedule, one_of(schedule_names()), "schedule of the learning rates"),
      key("decay", &T::decay, Rule{.low = 0, .high = 1, .low_is_open = true},
          "factor of the exponential schedule per step"),
      only_when_given(key("gradient_clip", &T::gradient_clip, at_least(0),
                          "largest norm of a gradient; a longer one is scaled down to it; 0: no limit")),
      key("weight_decay", &T::weight_decay, at_least(0), "decay of T*'s weights, decoupled as in AdamW"),
      key("ema", &T::ema, share_below_one(),
          "factor of an exponential average of the weights, which becomes the model; 0: no average"),
      key("noise", &T::noise, any(),
          "noise of the outputs, drawn again in each step; a list: one for each output; see nlo evaluate --noise"),
      only_when_given(key("noise_mixture", &T::noise_mixture, any(),
                          "used instead of noise: these noises alternate between trajectories; one observer is trained "
                          "for all of them")),
      only_when_given(key("input_noise", &T::input_noise, any(),
                          "noise of the inputs that the observer reads; the plant gets them without noise")),
      key("noise_level_max", &T::noise_level_max, at_least(0),
          "> 0: the noise of each trajectory is scaled by a number in [0, max]"),
      only_when_given(key("dropout", &T::dropout, share_below_one(),
                          "share of the segments in which a sensor of [observer] may_fail is missing")),
      key("mirror", &T::mirror, any(),
          "true: half of the segments are mirrored, that is, all channels except even ones change their sign; the "
          "plant "
          "must be odd, which is checked"),
      key("gradient", &T::gradient, names_of<LatentGradient>(),
          "gradient of the latent system; automatic: the exact filter if it is linear, else backprop"),
      key("transient", &T::transient, names_of<Transient>(),
          "treatment of the transient at the start; drop: samples at t < t_c do not count; backward: trajectories "
          "begin "
          "t_c earlier, in the simulated past of the plant"),
      key("transient_factor", &T::transient_factor, positive(),
          "k of t_c = k / min |Re lambda|, over the initial eigenvalues except clocks"),
      key("validate_every", &T::validate_every, between(1, 1e8), "steps between validation errors"),
      key("checkpoint_every_s", &T::checkpoint_every_s, positive(), "time between checkpoints [s]"),
  };
  return kKeys;
}

template <>
const std::vector<Key<EvaluationConfig>>& keys() {
  using V = EvaluationConfig;
  static const std::vector<Key<V>> kKeys = {
      key("windows", &V::windows, Rule{.at_most = 6},
          "windows of time for the errors; if not given: a transient and a settled window that fit the plant"),
      key("settling_window_s", &V::settling_window_s, at_least(0),
          "time over which errors are averaged for the settling time [s]; 0: a tenth of the transient"),
  };
  return kKeys;
}

template <>
const std::vector<Key<ValidationConfig>>& keys() {
  using V = ValidationConfig;
  static const std::vector<Key<V>> kKeys = {
      key("groups", &V::groups, any(),
          "regular expression: logs with the same match in their names are left out together; empty: each log is left "
          "out alone"),
      key("folds", &V::folds, between(0, 50),
          "number of trainings that leave out some of the training logs, each with half of the steps; their errors on "
          "the left-out logs select the readout of each state; 0: no such trainings"),
  };
  return kKeys;
}

// clang-format off
template <> std::string_view section_title<Experiment>() { return "the experiment"; }
template <> std::string_view section_title<PlantConfig>() { return "[plant]"; }
template <> std::string_view section_title<SimulationConfig>() { return "[simulation]"; }
template <> std::string_view section_title<LogConfig>() { return "[log]"; }
template <> std::string_view section_title<ColumnConfig>() { return "[[log.columns]]"; }
template <> std::string_view section_title<VelocityFilterConfig>() { return "[log.velocity_filter]"; }
template <> std::string_view section_title<ObserverConfig>() { return "[observer]"; }
template <> std::string_view section_title<DynamicsConfig>() { return "[dynamics]"; }
template <> std::string_view section_title<InverseMapConfig>() { return "[inverse_map]"; }
template <> std::string_view section_title<ForwardMapConfig>() { return "[forward_map]"; }
template <> std::string_view section_title<LossConfig>() { return "[loss]"; }
template <> std::string_view section_title<TrainingConfig>() { return "[training]"; }
template <> std::string_view section_title<ValidationConfig>() { return "[validation]"; }
template <> std::string_view section_title<EvaluationConfig>() { return "[evaluation]"; }
// clang-format on

}  // namespace nlo::trainer
