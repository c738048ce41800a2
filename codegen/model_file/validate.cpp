// SPDX-License-Identifier: MIT
#include "codegen/model_file/validate.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "codegen/base/identifier.h"
#include "codegen/model/computed_outputs.h"
#include "codegen/model/domain.h"
#include "codegen/model/field_checks.h"
#include "codegen/model_file/monitor_fields.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

void check_inputs(const Model& m) {
  const auto count = static_cast<Eigen::Index>(m.inputs.size());
  check_shape(m.input_min, count, "input_min", "n_u");
  check_shape(m.input_max, count, "input_max", "n_u");
  if (m.inputs.empty()) return;
  if (!module_of(m).reads_inputs())
    fail("inputs is not used by a {} observer, which has its own field; leave it out", structure_name(m));
  check_channels(m.inputs, "inputs");
  check_range(m.input_min, m.input_max, "input");
  for (std::size_t i = 0; i < m.inputs.size(); ++i) {
    if (m.inputs[i].wrap != 0.0) fail("inputs[{}].wrap is {}; an input is not unwrapped: write 0", i, m.inputs[i].wrap);
    for (const Channel& output : m.outputs)
      if (output.name == m.inputs[i].name)
        fail("inputs[{}] is called \"{}\", like an output; rename one", i, output.name);
  }
  if (m.input_hold == Hold::kRk4)
    fail("input_hold is unknown; use zero_order (a command that has acted since the last sample) or first_order");
  if (m.input_hold == Hold::kFirstOrder && m.hold == Hold::kZeroOrder)
    fail(
        "input_hold is first_order, but hold is zero_order; an input that is interpolated needs hold = first_order, a "
        "command needs input_hold = zero_order");
}

/// Checks that outputs are computed only from readings that the structure can have.
void check_computed(const Model& m) {
  for (const auto& [channels, field] : {std::pair{&m.inputs, "inputs"}, std::pair{&m.states, "states"}})
    for (std::size_t i = 0; i < channels->size(); ++i)
      if (!(*channels)[i].expression.empty())
        fail("{}[{}].expression is \"{}\"; only outputs can be computed: remove the expression", field, i,
             (*channels)[i].expression);
  const ComputedOutputs computed(m.outputs, m.inputs);
  if (computed.none()) return;
  if (computed.first() == 0) fail("outputs are all computed; an observer needs at least one measured output");
  if (!module_of(m).computes_outputs())
    fail("outputs[{}].expression exists only for structure {}, but this model is {}; leave it out", computed.first(),
         names_of_structures([](const StructureModule& s) { return s.computes_outputs(); }), structure_name(m));
  const auto may_fail = [&](int output) {
    const std::vector<int>& failing = m.failures.outputs;
    return std::find(failing.begin(), failing.end(), output) != failing.end();
  };
  for (std::size_t i = 0; i < computed.all().size(); ++i) {
    const int output = computed.first() + static_cast<int>(i);
    const std::vector<int>& reads = computed.all()[i].reads();
    if (std::any_of(reads.begin(), reads.end(), may_fail) && !may_fail(output))
      fail("may_fail.outputs lacks {}: \"{}\" is computed from an output that may be missing", output,
           m.outputs[static_cast<std::size_t>(output)].name);
  }
}

void check_failures(const Model& m) {
  const SensorFailures& f = m.failures;
  check_shape(f.rest, static_cast<Eigen::Index>(f.outputs.size()), "may_fail.rest", "one for each of may_fail.outputs");
  if (f.none()) return;
  if (!module_of(m).reads_stalenesses())
    fail("may_fail exists only for structure {}, but this model is {}; leave it out",
         names_of_structures([](const StructureModule& s) { return s.reads_stalenesses(); }), structure_name(m));
  if (!(f.staleness_s > 0.0) || !std::isfinite(f.staleness_s))
    fail("may_fail.staleness_s is {}; it must be positive", f.staleness_s);
  // A faster one has decayed by the next sample, and float32 cannot distinguish a slower one from none.
  constexpr double kShortest = 1e-3, kLongest = 1e6;
  if (!(f.staleness_s >= kShortest * m.sample_period_s && f.staleness_s <= kLongest * m.sample_period_s))
    fail("may_fail.staleness_s is {}; it must be from {:g} to {:g} sample periods of {} s", f.staleness_s, kShortest,
         kLongest, m.sample_period_s);
  for (std::size_t i = 0; i < f.outputs.size(); ++i) {
    const int output = f.outputs[i];
    if (output < 0 || output >= m.ny() || (i > 0 && output <= f.outputs[i - 1]))
      fail("may_fail.outputs[{}] is {}; write numbers of outputs, from 0 to {}, in increasing order", i, output,
           m.ny() - 1);
    if (m.outputs[static_cast<std::size_t>(output)].wrap != 0.0)
      fail(
          "may_fail.outputs[{}] is the angle \"{}\"; a missing output decays to its mean, but an angle has no mean: "
          "leave it out",
          i, m.outputs[static_cast<std::size_t>(output)].name);
    const double rest = f.rest(static_cast<Eigen::Index>(i));
    if (!(rest >= m.output_min(output) && rest <= m.output_max(output)))
      fail("may_fail.rest[{}] is {}; it must lie within the range of its output", i, rest);
  }
}

/// Checks the channels that have their own period.
void check_periods(const Model& m) {
  for (const auto& [channels, field] : {std::pair{&m.inputs, "inputs"}, std::pair{&m.states, "states"}})
    for (std::size_t i = 0; i < channels->size(); ++i)
      if ((*channels)[i].period_s != 0.0)
        fail("{}[{}].period_s is {}; only an output has a period of its own: leave it out", field, i,
             (*channels)[i].period_s);
  constexpr double kLongest = 5000.0;  // sample periods; the runtime counts to 16,383
  for (std::size_t j = 0; j < m.outputs.size(); ++j) {
    const double period_s = m.outputs[j].period_s;
    if (period_s == 0.0) continue;
    if (!m.outputs[j].expression.empty())
      fail(
          "outputs[{}].period_s is {} and its expression \"{}\"; a computed output has the period of its parts: leave "
          "period_s out",
          j, period_s, m.outputs[j].expression);
    if (!(period_s >= kShortestOutputPeriod * m.sample_period_s && period_s <= kLongest * m.sample_period_s))
      fail("outputs[{}].period_s is {}; it must be from {:g} to {:g} sample periods of {} s, or be left out", j,
           period_s, kShortestOutputPeriod, kLongest, m.sample_period_s);
  }
}

void check_saturation(const Model& m) {
  if (!m.saturates()) return;
  if (!module_of(m).saturates())
    fail("saturation exists only for structure {}, but this model is {}; leave it out",
         names_of_structures([](const StructureModule& s) { return s.saturates(); }), structure_name(m));
  if (!(m.saturation > 0.0) || !std::isfinite(m.saturation))
    fail("saturation is {}; it must be a positive number of half ranges of z, or be left out", m.saturation);
  const LatentReach reach(m);
  for (Eigen::Index r = 0; r < m.nz(); ++r)
    if (!(reach.min(r) >= -kLargestNumber && reach.max(r) <= kLargestNumber))
      fail("saturation is {} and lets T* read z[{}] from {} to {}; float32 requires it within +-{}", m.saturation, r,
           reach.min(r), reach.max(r), kLargestNumber);
}

/// Turns are counted in an int32, and the angle within a turn needs the 24 bits of float32.
void check_turns(const Model& m) {
  constexpr double kMostTurns = 1e5;
  for (int j = 0; j < m.ny(); ++j) {
    const double turn = m.outputs[static_cast<std::size_t>(j)].wrap;
    const double largest = std::max(std::abs(m.output_min(j)), std::abs(m.output_max(j)));
    if (turn != 0.0 && !(largest <= kMostTurns * turn))
      fail(
          "outputs[{0}].wrap is {1} and its range reaches {2}, but an angle may have at most {3:g} turns: give the "
          "full turn in its unit, or measure it within fewer turns",
          j, turn, largest, kMostTurns);
  }
}

void check_sampling(const Model& m) {
  if (!(m.sample_period_s > 0.0) || !std::isfinite(m.sample_period_s))
    fail("sample_period_s is {}; it must be positive", m.sample_period_s);
  if (!(m.sample_period_s >= kSmallestNumber && m.sample_period_s <= kLargestNumber))
    fail("sample_period_s is {}; float32 requires it from {} to {}", m.sample_period_s, kSmallestNumber,
         kLargestNumber);
  check_shape(m.output_min, m.ny(), "output_min", "n_y");
  check_shape(m.output_max, m.ny(), "output_max", "n_y");
  check_range(m.output_min, m.output_max, "output");
  check_turns(m);

  check_inputs(m);
  check_computed(m);
  check_failures(m);
  check_periods(m);

  const int nz = m.nz();
  if (nz == 0) fail("initial_latent is empty; an observer has at least one latent state");
  check_shape(m.initial_latent, nz, "initial_latent", "n_z");
  for (Eigen::Index r = 0; r < nz; ++r)
    if (!(std::abs(m.initial_latent(r)) <= kLargestNumber))
      fail("initial_latent[{}] is {}; float32 requires it within +-{}", r, m.initial_latent(r), kLargestNumber);
  check_shape(m.latent_min, nz, "latent_min", "n_z");
  check_shape(m.latent_max, nz, "latent_max", "n_z");
  check_range(m.latent_min, m.latent_max, "latent");
  check_saturation(m);
}

void check_clocks(const Model& m) {
  for (const Named<const Network>& n : networks(m))
    if (!n.network->feature_clocks.empty() && !(n.field == "inverse_map" && module_of(m).multiplies_by_clocks()))
      fail("{}.feature_clocks belongs to the inverse_map of structure {}; leave it out", n.field,
           names_of_structures([](const StructureModule& s) { return s.multiplies_by_clocks(); }));
}

void check_fallbacks(const Model& m) {
  for (const Named<const Network>& n : networks(m)) {
    if (n.network->fallback.outputs.empty()) continue;
    if (n.field != "inverse_map")
      fail("{0} has no fallback, only inverse_map has one; leave {0}.fallback out", n.field);
    for (const int output : n.network->fallback.outputs)
      if (const Channel& state = m.states[static_cast<std::size_t>(output)]; state.wrap > 0.0)
        fail("inverse_map.fallback.outputs contains state {}, which wraps; leave it out", state.name);
  }
}

void check_error(const Model& m) {
  if (!m.error) return;
  const ErrorHead& head = *m.error;
  const Network* map = inverse_map(m);
  if (map == nullptr || map->layers.size() < 2)
    fail("error reads the last hidden layer of inverse_map, but this model has no hidden layer; leave error out");
  check_shape(head.weights, m.nx(), 2 * map->layers.back().weights.cols(), "error.weights",
              "n_x x twice the neurons of the last hidden layer");
  check_shape(head.bias, m.nx(), "error.bias", "n_x");
  check_shape(head.log_min, m.nx(), "error.log_min", "n_x");
  check_shape(head.log_max, m.nx(), "error.log_max", "n_x");
  check_shape(head.factor_68, m.nx(), "error.factor_68", "n_x");
  check_shape(head.factor_95, m.nx(), "error.factor_95", "n_x");
  // Largest log sigma and factor that float and nlo/error_head.h can represent.
  constexpr double kMostLog = 60.0, kMostFactor = 1e3;
  for (Eigen::Index i = 0; i < m.nx(); ++i) {
    if (!(head.log_min(i) <= head.log_max(i) && head.log_min(i) >= -kMostLog && head.log_max(i) <= kMostLog))
      fail(
          "error.log_min[{0}] is {1} and error.log_max[{0}] is {2}; the first must be the smaller one, and both within "
          "+-{3}",
          i, head.log_min(i), head.log_max(i), kMostLog);
    if (!(head.factor_68(i) >= 1.0 / kMostFactor && head.factor_95(i) <= kMostFactor &&
          head.factor_68(i) <= head.factor_95(i)))
      fail(
          "error.factor_68[{0}] is {1} and error.factor_95[{0}] is {2}; the first must be the smaller one, and both "
          "from {3:g} to {4:g}",
          i, head.factor_68(i), head.factor_95(i), 1.0 / kMostFactor, kMostFactor);
  }
}

void check_flight(const Model& m) {
  const Flight& f = m.flight;
  if (f.runs.empty()) return;
  check_shape(f.output_step, m.ny(), "flight.output_step", "n_y");
  check_shape(f.input_step, m.nu(), "flight.input_step", "n_u");
  check_positive(f.output_step, "flight.output_step");
  check_positive(f.input_step, "flight.input_step");
  if (!(f.dt_step_s > 0.0) || !std::isfinite(f.dt_step_s))
    fail("flight.dt_step_s is {}; it must be positive", f.dt_step_s);
  if (f.samples() > kMostFlightSamples)
    fail("flight.runs have {} samples; leave some out, at most {} are allowed", f.samples(), kMostFlightSamples);
  for (std::size_t i = 0; i < f.runs.size(); ++i) {
    const FlightRun& run = f.runs[i];
    const Eigen::Index samples = run.outputs.cols();
    if (samples == 0) fail("flight.runs[{}] is empty; leave it out", i);
    if (run.outputs.rows() != m.ny() || run.inputs.rows() != m.nu() || (m.nu() > 0 && run.inputs.cols() != samples) ||
        (run.dt.size() != 0 && run.dt.size() != samples))
      fail(
          "flight.runs[{}] has {} outputs, {} inputs and {} times over {} samples; it must have {}, {} and 0 or one "
          "each",
          i, run.outputs.rows(), run.inputs.rows(), run.dt.size(), samples, m.ny(), m.nu());
    const auto beyond = [](const Eigen::MatrixXi& counts) {
      return counts.size() != 0 && (counts.minCoeff() < -kMostFlightCount || counts.maxCoeff() > kMostFlightCount);
    };
    if (beyond(run.outputs) || beyond(run.inputs))
      fail("flight.runs[{}] has a count beyond 2^24; use a larger step", i);
    if (run.dt.size() != 0 && (run.dt.minCoeff() < 1 || run.dt.maxCoeff() > kMostFlightCount))
      fail("flight.runs[{}].dt has a count that is not from 1 to 2^24; time must increase", i);
  }
}

}  // namespace

void validate(const Model& m) {
  if (!is_identifier(m.name))
    fail("name is not an identifier; use a letter, then letters, digits and underscores (63 at most), no C++ keyword");
  check_channels(m.outputs, "outputs");
  check_channels(m.states, "states");
  check_sampling(m);
  check_clocks(m);
  module_of(m).check(m);
  check_fallbacks(m);
  check_monitor(m);
  check_error(m);
  check_flight(m);
  for (std::size_t i = 0; i < m.provenance.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (m.provenance[i].first == m.provenance[j].first)
        fail("provenance has \"{}\" twice; keep one", m.provenance[i].first);
}

}  // namespace nlo::codegen
