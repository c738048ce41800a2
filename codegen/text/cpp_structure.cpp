// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_structure.h"

#include <fmt/format.h>

#include "codegen/base/number.h"

namespace nlo::codegen {

std::string hold_identifier(Hold hold) {
  switch (hold) {
    case Hold::kZeroOrder:
      return "Hold::kZeroOrder";
    case Hold::kFirstOrder:
      return "Hold::kFirstOrder";
    case Hold::kRk4:
      return "Hold::kRk4";
  }
  return {};
}

CppStructureBase::CppStructureBase(const ExportSource& s)
    : m_(s.model),
      f_(s.folded),
      init_(s.init),
      quantised_(s.quantised),
      nx_(s.model.nx()),
      ny_(s.model.ny()),
      nr_(s.model.nr()),
      read_inputs_(static_cast<Eigen::Index>(s.model.inputs.size())),
      nz_(s.model.nz()) {}

std::string CppStructureBase::trailing_fields() const {
  std::string text;
  for (const CppNetwork& n : networks()) text += n.initialiser(init_, n.field.substr(n.field.rfind('.') + 1));
  return text;
}

namespace {

/// Template arguments of a model that follow T*, and the words that name each argument in a comment behind them.
struct Arguments {
  std::string values, words;
  void add(const std::string& value, const char* word) {
    values += ", " + value;
    words += word;
  }
};

Arguments optional_arguments(const Model& m, bool may_saturate) {
  // An argument that is written needs all arguments before it.
  const bool computed = m.measured() < m.ny(), saturation = m.saturates() || (computed && may_saturate);
  const bool failures = computed || saturation || !m.failures.none();
  const bool hold = failures || m.input_hold != Hold::kZeroOrder;
  Arguments result;
  if (hold || !m.inputs.empty()) result.add(std::to_string(m.inputs.size()), ", n_u");
  if (hold) result.add(hold_identifier(m.input_hold), ", hold of u");
  if (failures) result.add(std::to_string(m.failures.outputs.size()), ", sensors that may fail");
  if (saturation)
    result.add(!m.saturates()          ? "Saturation::kNone"
               : saturates_relative(m) ? "Saturation::kRelativeLatent"
                                       : "Saturation::kLatent",
               ", what saturates");
  if (computed) result.add("Computed", ", outputs that are computed");
  return result;
}

}  // namespace

std::string CppStructureBase::input_arguments() const {
  return optional_arguments(m_, may_saturate()).values;
}

std::string CppStructureBase::input_words() const {
  return optional_arguments(m_, may_saturate()).words;
}

std::string CppStructureBase::input_comment() const {
  std::string text;
  if (read_inputs_ > 0)
    text += fmt::format("// Inputs are read beside the outputs; {}.\n", m_.input_hold == Hold::kZeroOrder
                                                                            ? "u has acted since the last sample"
                                                                            : "u is interpolated like y");
  for (const Channel& output : m_.outputs)
    if (!output.expression.empty()) text += fmt::format("// Computed: {} = {}.\n", output.name, output.expression);
  std::string names;
  for (const int output : m_.failures.outputs)
    names += (names.empty() ? "" : ", ") + m_.outputs[static_cast<std::size_t>(output)].name;
  if (!names.empty()) text += fmt::format("// May be missing (NaN) for any time: {}.\n", names);
  if (m_.saturates())
    text +=
        fmt::format("// T* reads z limited to its domain and a margin of {} half ranges.\n", literal(m_.saturation));
  return text;
}

std::string CppStructureBase::reads(bool latent_alone) const {
  if (latent_alone) return "z";
  return fmt::format("[z; y{}{}]", read_inputs_ > 0 ? "; u" : "", m_.failures.none() ? "" : "; staleness");
}

CppNetwork CppStructureBase::inverse_map() const {
  const FoldedNetwork& map = f_.network("inverse_map");
  return {map,
          map.field,
          "Layer",
          "Network",
          reads(map.inputs() == nz_),
          quantised_ ? &quantised_->map : nullptr,
          f_.error ? &*f_.error : nullptr};
}

CppNetwork CppStructureBase::network(const std::string& field, const std::string& layer, const std::string& type,
                                     const std::string& reads) const {
  return {f_.network(field), field, layer, type, reads};
}

}  // namespace nlo::codegen
