// SPDX-License-Identifier: MIT
#include "codegen/readback/common_quantities.h"

#include <nlo/kernels/activation.h>
#include <nlo/kernels/int16.h>
#include <nlo/monitor_model.h>
#include <nlo/vector.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "codegen/model/activations.h"
#include "codegen/model/computed_outputs.h"
#include "codegen/structures/module.h"
#include "codegen/text/cpp_monitor.h"
#include "codegen/text/flown_number.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// "INNOVATION_MEAN" as the single header has it, "kInnovationMean"; "mean_limit" as a constant, "kMeanLimit".
std::string as_constant(const std::string& name) {
  std::string text = "k";
  bool upper = true;
  for (const char c : name) {
    const auto code = static_cast<unsigned char>(c);
    if (c != '_') text += static_cast<char>(upper ? std::toupper(code) : std::tolower(code));
    upper = c == '_';
  }
  return text;
}

/// Readings and the inputs that act apart from them: what C99 holds.
Index held(const Model& m) {
  return m.nr() + m.nu() - static_cast<Index>(m.inputs.size());
}

void add_names(Quantities& to, const std::vector<Channel>& channels, const char* scope, const char* prefix) {
  for (std::size_t i = 0; i < channels.size(); ++i)
    to.integer(channels[i].name, scope + ("::" + channels[i].name), prefix + channels[i].name, static_cast<double>(i));
}

/// Enumerators of C99, which the runtime has too.
void add_enumerators(Quantities& to, TextForm form, const char* type,
                     const std::vector<std::pair<std::string, int>>& all) {
  for (const auto& [name, value] : all)
    to.integer("the runtime's", "", form == TextForm::kSingle ? std::string(type) + "::" + as_constant(name) : name,
               value);
}

void add_sizes(Quantities& to, TextForm form) {
  const Model& m = to.source().model;
  const auto size = [&](const std::string& name, Index value, Index seen) {
    to.integer("how many there are", "", "kN" + name, static_cast<double>(value));
    std::string outside = "N";
    outside += static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    if (form == TextForm::kC99 && seen >= 0) to.integer("how many there are", "", outside, static_cast<double>(seen));
  };
  size("x", m.nx(), m.nx());
  size("y", m.ny(), m.measured());
  size("z", m.nz(), m.nz());
  if (m.nu() > 0) size("u", m.nu(), m.nu());
  if (held(m) > m.ny()) size("r", held(m), -1);
  if (!m.failures.none()) size("f", static_cast<Index>(m.failures.outputs.size()), -1);
  to.words("scalar", "", "Scalar", {to.source().init.scalar_name()});
}

void add_ranges(Quantities& to) {
  const Model& m = to.source().model;
  const bool single = to.source().init.scalar_bytes() == 4;
  const std::vector<Channel> channels = readings(m);
  VectorXd wrap = VectorXd::Zero(held(m));
  for (int j = 0; j < m.nr(); ++j) wrap(j) = channels[static_cast<std::size_t>(j)].wrap;
  // Inputs that act apart from the readings are taken as they come.
  const double largest =
      single ? static_cast<double>(std::numeric_limits<float>::max()) : std::numeric_limits<double>::max();
  VectorXd least = VectorXd::Constant(held(m), -largest), most = VectorXd::Constant(held(m), largest);
  least.head(m.nr()) = reading_min(m);
  most.head(m.nr()) = reading_max(m);
  to.scalar("sample_period_s", "kModel.sample_period_s", "kSamplePeriod", m.sample_period_s);
  to.integer("stale after", "kModel.stale_after", "kStaleAfter", to.source().folded.stale_after);
  to.vector("output_min and input_min", "kModel.outputs.min", "", reading_min(m));
  to.vector("output_max and input_max", "kModel.outputs.max", "", reading_max(m));
  to.vector("wrap of the outputs", "kModel.outputs.wrap", "", wrap.head(m.nr()));
  to.vector("output_min and input_min", "", "kOutputMin", least);
  to.vector("output_max and input_max", "", "kOutputMax", most);
  to.vector("wrap of the outputs", "", wrap.isZero(0.0) ? "" : "kWrap", wrap);
  to.vector("latent_min", "kModel.domain.latent_min", "kLatentMin", m.latent_min);
  to.vector("latent_max", "kModel.domain.latent_max", "kLatentMax", m.latent_max);
  to.vector("initial_latent", "", "kInitial", m.initial_latent);
  to.vector("no reading", "", "kNoOutput", VectorXd::Zero(held(m)));
  to.scalar("the largest |z|", "", "kLargest", 0x1p100);
  to.scalar("the smallest |z|", "", "kTiny", 0x1p-100);
}

void add_failures(Quantities& to) {
  const Model& m = to.source().model;
  if (m.failures.none()) return;
  const SensorFailures& f = m.failures;
  const Eigen::VectorXi outputs =
      Eigen::Map<const Eigen::VectorXi>(f.outputs.data(), static_cast<Index>(f.outputs.size()));
  to.integers("may_fail.outputs", "kModel.failures.output", "kMayFail", outputs.cast<double>());
  to.vector("may_fail.rest", "kModel.failures.rest", "fill_missing.kRest", f.rest);
  to.scalar("may_fail.staleness_s", "kModel.failures.rate", "", 1.0 / f.staleness_s);
  to.scalar("may_fail.staleness_s", "kModel.failures.keep", "", std::exp(-m.sample_period_s / f.staleness_s));
}

/// What C99 evaluates activations by: the runtime's tables.
void add_functions(Quantities& to) {
  const FoldedModel& folded = to.source().folded;
  const QuantisedModel* integers = to.source().quantised;
  bool tanh = false;
  for (const FoldedNetwork& n : folded.networks) {
    if (integers != nullptr && (n.field == "inverse_map" || integers->units)) continue;
    tanh = tanh || n.field == "gates" || (n.layers.size() > 1 && n.activation != Activation::kRelu);
  }
  constexpr const auto& kFit = kTanhFit<Activation::kTanh, double>;
  if (tanh && to.source().init.scalar_bytes() == 8) {
    to.vector("tanh of the runtime", "", "kTanhP", Eigen::Map<const VectorXd>(kFit.p, kFit.kTerms));
    to.vector("tanh of the runtime", "", "kTanhQ", Eigen::Map<const VectorXd>(kFit.q, kFit.kTerms));
  }
  if (integers == nullptr) return;
  if (!integers->units && (integers->map.layers.size() < 2 || integers->map.activation == Activation::kRelu)) return;
  VectorXd table(static_cast<Index>(std::size(kernels::int16::kTanhTable)));
  std::copy(std::begin(kernels::int16::kTanhTable), std::end(kernels::int16::kTanhTable), table.begin());
  to.integers("tanh of the runtime", "", "kTanhTable", table);
}

/// What C99 does of what the model may ask for.
void add_code(Quantities& to) {
  const Model& m = to.source().model;
  const std::string f = to.source().init.scalar_bytes() == 4 ? "f" : "";
  bool angles = false, relative = false;
  for (const Channel& channel : readings(m)) angles = angles || channel.wrap > 0.0;
  for (int j = 0; j < m.nr(); ++j) relative = relative || is_relative(m, j);
  to.code("wrap of the outputs", "screened", "wrapped(y[j]-accepted[j],kWrap[j])", angles);
  to.code("wrap of the outputs", "take", "turn_back(o);", angles);
  to.code("relative_outputs", "in_domain", "relative=observer->z[r]-resting(observer,r);", relative);
  to.code("saturation", "estimate", "saturated(observer,in);", m.saturates());
  to.code("input_hold", "take", "copy(o->y+kNy,next+kNy,kNu);",
          m.nu() > 0 && module_of(m).input_hold(m) == Hold::kZeroOrder);
  to.code("may_fail", "take", "note_missing(o,missing);", !m.failures.none());
  if (!m.failures.none())
    to.code("may_fail.staleness_s", "make_step",
            "step->keep=decay_minus_1(" + to.source().init(1.0 / m.failures.staleness_s, "may_fail.staleness_s") +
                "*h)+1.0" + f + ";",
            true);
}

/// Outputs that are computed of readings r.
template <class Scalar>
void add_computed(Quantities& to) {
  const Model& m = to.source().model;
  if (m.measured() == m.ny()) return;
  to.code("expression of an output", "take", "compute(given);", true);
  const auto fill = [computed = ComputedOutputs(m.outputs, m.inputs)](Quantity::Arrays& arrays) {
    std::vector<double>& r = arrays.at("r");
    for (std::size_t i = 0; i < computed.all().size(); ++i)
      r[static_cast<std::size_t>(computed.first()) + i] =
          computed.all()[i]
              .evaluate<FlownNumber<Scalar>>(
                  [&](int j) { return FlownNumber<Scalar>::computed(r[static_cast<std::size_t>(j)]); })
              .value;
  };
  to.formula("expression of an output", "Computed::fill", "compute",
             {{"r", std::vector<double>(static_cast<std::size_t>(m.nr()))}}, fill);
}

void add_monitor(Quantities& to, TextForm form) {
  const Model& m = to.source().model;
  if (!m.monitor) return;
  for (const MonitorConstant& c : monitor_constants(m, to.source().init)) {
    const std::string cpp = std::string("kMonitor.") + c.name, c99 = "kWatch" + as_constant(c.name).substr(1);
    c.is_integer() ? to.integers(c.field, cpp, c99, c.values) : to.matrix(c.field, cpp, c99, c.values);
  }
  const Index windows = m.monitor->windows();
  std::vector<std::string> type = {"nlo::MonitorModel", to.source().init.scalar_name()};
  for (const Index size : {Index{m.nx()}, Index{m.ny()}, Index{m.nz()}, Index{m.nr()}, windows})
    type.push_back(std::to_string(size));
  to.words("monitor", "MonitorModel", "", type);
  to.words("monitor", "Monitor", "", {"nlo::Monitor", "MonitorModel"});
  to.integer("monitor.windows_s", "", "kWindows", static_cast<double>(windows));
  to.integer("monitor.prediction", "", "kWatchFeatures", m.nz() + m.nr() + m.nx());
  to.integer("the runtime's", "", "kMostRejected", kMostRejected);
  if (m.monitor->compares_row()) to.integer("monitor.row", "", "kWatchRowFeatures", m.nz() + m.nr());
  if (!m.monitor->freezes_none()) to.integer("the runtime's", "", "kFrozen", 65535);
  to.scalar("the runtime's", "", "kFar", 1e6);
  to.scalar("the runtime's", "", "kLargestInnovation", kLargestInnovation);
  to.scalar("the runtime's", "", "kLargestSquare", kLargestInnovation * kLargestInnovation);
  to.scalar("the runtime's", "", "kMostSquare", kLargestInnovation * kLargestInnovation * 1.01);
  const bool single = form == TextForm::kSingle;
  add_enumerators(to, form, "Alarm",
                  {{single ? "NONE" : "NO_ALARM", 0},
                   {"INNOVATION_MEAN", 1},
                   {"INNOVATION_VARIANCE", 2},
                   {"INNOVATION_CORRELATION", 3},
                   {"LATENT_DISTANCE", 4},
                   {"MISSING", 5},
                   {"DISAGREEMENT", 6},
                   {single ? "RESET" : "MONITOR_RESET", 7}});
}

}  // namespace

void add_common_quantities(Quantities& to, const PreparedExport& prepared, TextForm form) {
  const Model& m = prepared.model();
  const bool single = form == TextForm::kSingle;
  to.words("name", "namespace", single ? "namespace" : "", {(single ? "nlo::single::" : "nlo::") + prepared.name()});
  add_names(to, measured_channels(m), "Output", "output_");
  add_names(to, inputs(m), "Input", "input_");
  add_names(to, m.states, "State", "state_");
  add_sizes(to, form);
  add_ranges(to);
  add_failures(to);
  add_functions(to);
  add_code(to);
  prepared.initialiser().scalar_bytes() == 4 ? add_computed<float>(to) : add_computed<double>(to);
  add_monitor(to, form);
  if (m.measured() < m.ny()) to.integer("outputs that are computed", "Computed::kCount", "", m.ny() - m.measured());
  std::vector<std::pair<std::string, int>> statuses = {{"OK", static_cast<int>(StepStatus::kOk)},
                                                       {"CLAMPED", static_cast<int>(StepStatus::kClamped)},
                                                       {"HELD", static_cast<int>(StepStatus::kHeld)},
                                                       {"STALE", static_cast<int>(StepStatus::kStale)},
                                                       {"REJECTED", static_cast<int>(StepStatus::kRejected)},
                                                       {"RESET", static_cast<int>(StepStatus::kReset)}};
  if (module_of(m).may_diverge()) statuses.emplace_back("DIVERGED", static_cast<int>(StepStatus::kDiverged));
  add_enumerators(to, form, "Status", statuses);
}

}  // namespace nlo::codegen
