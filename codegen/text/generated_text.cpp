// SPDX-License-Identifier: MIT
#include "codegen/text/generated_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "codegen/base/error.h"
#include "codegen/base/identifier.h"
#include "codegen/base/number.h"
#include "codegen/model/computed_outputs.h"

namespace nlo::codegen {
namespace {

// Names of the runtime in the namespace nlo. A model is a namespace in it, so it must not have one of these names.
// cpp_header_test.cpp finds missing names. Formatted by hand, because the formatter would write one name per line.
// clang-format off
constexpr std::array kRuntimeNames = {
    "Activation", "Alarm", "Arithmetic", "Bfloat16", "CarriedLimits", "CarriedModel", "CarriedObserver", "ClockProducts", "Complex", "ComputesIn", "NoComputed", "DelayLine", "Dense", "Domain", "DrivenKklModel",
    "DrivenKklObserver", "ErrorHead", "EstimateWithError", "ExpSeries", "ChannelHealth", "Float16", "ForcedPhi", "ForcedStep", "ForcedWeights", "GateBuffers", "GatedBatch", "GatedModel", "GatedObserver", "GeneralModel", "GeneralObserver",
    "HasAdvance", "HasAdvanceByArrivals", "HasDrivenAdvance", "HasEstimate", "HasSizes", "HasStep", "HasValues",
    "Halved", "Hold", "InputField", "InputMemory", "InverseMap", "JvpBuffer", "KklBatch", "KklModel", "KklObserver", "KnowsError", "NoErrorHead", "FilterModel", "NoUnits", "FallbackRows", "NoFallback", "fall_back",
    "LatentModel", "LatentReach", "LatentStep", "LayerBuffer", "LearnedMap", "LinearPath", "LuenbergerModel", "LuenbergerObserver",
    "Mlp", "ModeStep", "Monitor", "MonitorModel", "ModeWeights", "NoClockProducts", "NoLinearPath", "ObserverCore", "ObserverModel", "ObserverState", "OutputRange", "PackedDense",
    "PackedQuantisedDense", "PanelDense", "Phi", "PriorModel", "PriorObserver", "QuantisedDense", "QuantisedMap", "QuantisedMlp", "QuantisedUnits", "SampledObserver", "SensorFailures",
    "SampledBatch", "Saturation", "SineAndCosine", "StepStatus", "Tableau", "ReadingRange", "Rotation", "TanhFit", "TargetDense", "Vector", "activate", "activation_slope", "add_forced",
    "add_relative_state", "add_steady_state", "advance", "all_below", "arc_tangent", "as_eigen", "between", "circle", "CircleFit", "cosine", "decay_minus_1", "discretise", "estrin", "evaluate_batch", "evaluate_inverse",
    "explicit_rk_step", "exponential", "exponential_rk_step", "forced_step", "forced_weights", "from_eigen", "gate_of", "gate_over", "horner", "hyperbolic_tangent", "in_triangle", "integrate",
    "is_below", "is_finite", "is_reachable", "is_tanh", "jvp", "restart", "rotation_vector", "kConstantTime", "kComputed", "kEuler", "kHeldOnce", "kHeldBit", "kClampedBit", "kMostCounted", "kHeun", "kLargestInnovation", "kLeastNoise", "kMostPieces", "kMostRejected", "kNoLimit", "kOrdinaryDisagreement", "kRk4",
    "kTanh5e5MaxError", "kTanh5e6MaxError", "kTanhFit", "kTanhMaxError", "kTanhMaxErrorDouble", "kUnknownSigma", "kernels", "log_1_plus", "logarithm", "magnitude", "make_mlp",
    "make_quantised_mlp", "make_unit", "maximum", "may_skip", "minimum", "multiply_add", "native", "next_health", "counted_on", "health_after_missed", "health_after_gap", "due_health", "due_health_of_failing", "absent_health", "kHasSlowOutputs", "most_missing", "never_arrived", "next_slow_health", "not_due", "missed_samples", "noise_of", "pack", "padded_inputs", "pieces_of", "power_of_2",
    "quantised_layer", "reciprocal", "rounded", "saturate", "saturated_at", "select", "sign_of", "simd", "sine", "square_root", "starts_steady", "status_of", "take_output", "tanh_rational", "triangle_size", "turn_back", "worse"};
// clang-format on

}  // namespace

std::string computed_statements(const Model& m, const Initialiser& init, const char* indent,
                                const std::function<std::string(const std::string&)>& part_of_sum) {
  const ComputedOutputs computed(m.outputs, m.inputs);
  std::string text;
  for (std::size_t i = 0; i < computed.all().size(); ++i)
    text += fmt::format("{}r[{}] = {};\n", indent, computed.first() + static_cast<int>(i),
                        computed.all()[i].text([](int j) { return fmt::format("r[{}]", j); },
                                               [&](double number) { return init(number, "expression"); }, part_of_sum));
  return text;
}

std::string Initialiser::operator()(double value, std::string_view field) const {
  if (scalar_ == ScalarType::kDouble) {
    if (!std::isfinite(value)) throw Error(fmt::format("{} overflows when it is folded; train again", field));
    return literal(value);
  }
  const float rounded = static_cast<float>(value);
  if (!std::isfinite(rounded))
    throw Error(
        fmt::format("{} is {} when folded, which exceeds the range of float; export with scalar double, or train again",
                    field, value));
  return literal(rounded);
}

std::string Initialiser::vector(const Eigen::VectorXd& values, std::string_view field) const {
  std::string text = "{";
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    text += (*this)(values(i), field);
  }
  return text + "}";
}

std::string Initialiser::matrix(const Eigen::MatrixXd& values, std::string_view field) const {
  std::string text = "{";
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    if (i > 0) text += ", ";
    text += vector(values.row(i), field);
  }
  return text + "}";
}

std::string Initialiser::rows(const Eigen::MatrixXd& values, int indent, std::string_view field) const {
  std::string text = "{\n";
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    text += std::string(static_cast<std::size_t>(indent), ' ') + vector(values.row(i), field) + ",\n";
  return text + std::string(static_cast<std::size_t>(indent - 2), ' ') + "}";
}

std::string safe_comment(std::string_view text, std::size_t longest) {
  constexpr std::string_view kSafe = " .,:;()[]+-=_/%<>^*|'#@&~";  // no backslash, no question mark (trigraphs)
  std::string safe(text.substr(0, longest));
  for (char& c : safe) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    if (!plain && kSafe.find(c) == std::string_view::npos) c = '_';
  }
  return safe;
}

std::string wrapped_comment(std::string_view comment) {
  constexpr std::size_t kColumns = 100;
  std::string text;
  while (!comment.empty()) {
    std::string_view line = comment.substr(0, comment.find('\n'));
    comment.remove_prefix(std::min(line.size() + 1, comment.size()));
    const bool is_list = line.starts_with("//   ");  // its continuation lines are indented
    for (bool first = true;; first = false) {
      const std::string_view begin = first ? "" : is_list ? "//     " : "// ";
      const std::size_t room = kColumns - begin.size(), break_at = line.rfind(' ', room);
      const bool fits = line.size() <= room, breaks = break_at != std::string_view::npos && break_at > 8;
      const std::size_t taken = fits || !breaks ? line.size() : break_at;
      text.append(begin).append(line.substr(0, taken)).append("\n");
      if (taken == line.size()) break;
      line.remove_prefix(taken + 1);
    }
  }
  return text;
}

std::string rounded_text(double value) {
  return fmt::format("{:.4g}", value);
}

std::string counted(std::string_view number, std::string_view noun) {
  return fmt::format("{} {}{}", number, noun, number == "1" ? "" : "s");
}

std::string grouped(Eigen::Index number) {
  std::string text = std::to_string(number);
  for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(text.size()) - 3; i > 0; i -= 3)
    text.insert(static_cast<std::size_t>(i), 1, ',');
  return text;
}

std::string export_name(const Model& model, const ExportOptions& options) {
  const std::string& name = options.name.empty() ? model.name : options.name;
  if (!is_identifier(name))
    throw Error(
        fmt::format("\"{}\" cannot name an export; use a letter, then letters, digits and underscores (63 at "
                    "most), no C++ keyword",
                    safe_comment(name, 80)));
  if (std::find(kRuntimeNames.begin(), kRuntimeNames.end(), name) != kRuntimeNames.end())
    throw Error(fmt::format("\"{}\" is a name of the runtime; export under another one", name));
  return name;
}

}  // namespace nlo::codegen
