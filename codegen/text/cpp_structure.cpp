// SPDX-License-Identifier: MIT
#include "codegen/text/cpp_structure.h"

#include <fmt/format.h>

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
      nz_(s.model.nz()) {}

std::string CppStructureBase::trailing_fields() const {
  std::string text;
  for (const CppNetwork& n : networks()) text += n.initialiser(init_, n.field.substr(n.field.rfind('.') + 1));
  return text;
}

std::string CppStructureBase::input_arguments() const {
  if (nr_ == ny_) return "";
  return fmt::format(", {}{}", nr_ - ny_,
                     m_.input_hold == Hold::kZeroOrder ? "" : ", " + hold_identifier(m_.input_hold));
}

std::string CppStructureBase::input_comment() const {
  if (nr_ == ny_) return "";
  return fmt::format("// Inputs are read beside the outputs; {}.\n",
                     m_.input_hold == Hold::kZeroOrder ? "u has acted since the last sample" : "u runs as y does");
}

CppNetwork CppStructureBase::inverse_map() const {
  const FoldedNetwork& map = f_.network("inverse_map");
  return {map,       map.field,    "Layer",
          "Network", "InverseMap", map.inputs() == nz_ ? "z" : nr_ > ny_ ? "[z; y; u]" : "[z; y]",
          quantised_};
}

CppNetwork CppStructureBase::network(const std::string& field, const std::string& layer, const std::string& type,
                                     const std::string& reads) const {
  return {f_.network(field), field, layer, type, "LearnedMap", reads};
}

}  // namespace nlo::codegen
