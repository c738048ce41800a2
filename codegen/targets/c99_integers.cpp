// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_integers.h"

#include <fmt/format.h>
#include <nlo/kernels/int16.h>

#include <set>

#include "codegen/base/embedded_text.h"
#include "codegen/model/activations.h"
#include "codegen/targets/c99_map.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

/// Returns integers of any type as an initialiser, `columns` of them per line.
template <class Values>
std::string integers(const Values& values, std::size_t columns) {
  std::string text = "{";
  std::size_t i = 0;
  for (const auto value : values) text += (i++ % columns == 0 ? "\n    " : " ") + std::to_string(value) + ",";
  return text + "\n}";
}

std::string integer_activation(Activation kind) {
  if (kind == Activation::kSilu)
    return "// Returns silu(2 h) = h + h tanh(h) in units of 2^-11; the argument is h in Q16.\n"
           "static int16_t silu_q15(int32_t argument) {\n"
           "  const int32_t end = 524288;  // 8 in Q16\n"
           "  const int32_t kept = (argument < -end) ? -end : ((argument > (end - 1)) ? (end - 1) : argument);\n"
           "  return (int16_t)rounded_down(rounded_down(kept, 4) * (32768 + (int32_t)tanh_q15(kept)), 16);\n"
           "}\n\n";
  if (kind == Activation::kRelu)
    return "// Returns relu in Q15.\n"
           "static int16_t relu_q15(int32_t value) {\n"
           "  return (int16_t)((value > 32767) ? 32767 : ((value < 0) ? 0 : value));\n"
           "}\n\n";
  return filled(embedded_text("c99/int16_tanh.c.in"), {{"TABLE", integers(kernels::int16::kTanhTable, 16)}});
}

}  // namespace

std::string c99_integer_arithmetic(const QuantisedModel& quantised) {
  std::set<Activation> kinds;
  if (quantised.units) kinds.insert(Activation::kTanh);
  const bool has_hidden = quantised.map.layers.size() > 1;
  if (has_hidden) kinds.insert(quantised.map.activation);
  if (kinds.contains(Activation::kSilu)) kinds.insert(Activation::kTanh);  // silu calls tanh, so tanh comes first
  std::string text(embedded_text("c99/int16.c.in"));
  if (!kinds.empty())
    text +=
        "static int32_t rounded_down(int32_t value, int bits) { return value >> bits; }  // as all compilers shift\n";
  for (const Activation kind : kinds) text += integer_activation(kind);
  if (has_hidden)
    text += filled(embedded_text("c99/int16_hidden.c.in"),
                   {{"ACTIVATION", std::string(activation_row(quantised.map.activation).name)}});
  return text;
}

std::string c99_integer_tables(const QuantisedLayer& layer, const std::string& weights, const std::string& bias) {
  const Eigen::Index rows = layer.weights.rows(), columns = layer.weights.cols();
  const Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic> by_rows = layer.weights.transpose();
  return fmt::format("static const IN_FLASH int16_t {}[{}] = {};\n", weights, c99_table_size(rows, columns),
                     integers(by_rows.reshaped(), static_cast<std::size_t>(columns))) +
         fmt::format("static const IN_FLASH int32_t {}[{}] = {};\n", bias, rows, integers(layer.bias, 8));
}

}  // namespace nlo::codegen
