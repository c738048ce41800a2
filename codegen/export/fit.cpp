// SPDX-License-Identifier: MIT
#include "codegen/export/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <tuple>

#include "codegen/base/key_values.h"
#include "codegen/export/cpp_cost.h"
#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/model/checks.h"
#include "codegen/structures/module.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;

/// Bytes of code and stack. Upper bounds over some fifty linked programs (g++ 12, -O2), T* of one to four hidden layers
/// of 4 to 128, n_z of 2 to 7: real programs take up to 1.5 KB less.
struct Calibration {
  Index base, per_latent;  ///< a program with a linear T*
  Index per_layer;         ///< each hidden layer of another shape (int16 without DSP instructions: each)
  Index tanh;              ///< int16: the table, and its use
  Index stack;             ///< beside the activations
};
struct Core {
  const char *name, *title;
  bool fpu;  ///< and DSP instructions: the assembly kernels
  Calibration in_float, in_int16;
};
constexpr Calibration kFpuFloat{1830, 50, 190, 0, 150}, kFpuInt16{2290, 50, 300, 1180, 180};
constexpr Calibration kSoftFloat{5310, 50, 660, 0, 96}, kSoftInt16{6170, 70, 420, 1260, 210};
constexpr std::array kCores = {
    Core{"m0plus", "M0+", false, kSoftFloat, kSoftInt16}, Core{"m4f", "M4F", true, kFpuFloat, kFpuInt16},
    Core{"m7", "M7", true, kFpuFloat, kFpuInt16}, Core{"m33", "M33", true, kFpuFloat, kFpuInt16}};

/// Of the float kernel (kernels/cortex_m.h), for each shape: ten inputs of a block and the rest, 4 bytes for each of
/// size + 1 instructions, of both sizes of its blocks; in hidden layers tanh or silu, four by four and the rest. Large
/// layers have tanh from a table, which they share.
Index float_blocks(const FoldedNetwork& n) {
  constexpr Index kAround = 5, kFours = 330, kOne = 68, kTable = 4096;
  bool table = false;
  std::set<std::pair<Index, Index>> shapes;
  Index bytes = 0;
  for (std::size_t l = 0; l < n.layers.size(); ++l) {
    const Index in = n.layers[l].weights.cols(), out = n.layers[l].bias.size();
    if (!shapes.emplace(in, out).second) continue;
    const Index blocks = (out + 12) / 13, small = out / blocks, inputs = (in >= 10 ? 10 : 0) + in % 10;
    for (const Index size : out % blocks == 0 ? std::vector<Index>{small} : std::vector<Index>{small, small + 1})
      bytes += 4 * (inputs * (size + 1) + kAround);
    if (l + 1 < n.layers.size() && n.activation != Activation::kRelu) bytes += kFours + kOne * (out % 4);
    table = table || (l + 1 < n.layers.size() && n.activation == Activation::kTanh && 4 * in * out >= kTable);
  }
  return table ? bytes + kTable : bytes;
}

/// Hidden layers whose code is not shared with another's.
Index hidden_layers(const std::vector<DenseLayer>& layers, bool share, const QuantisedNetwork* quantised) {
  std::set<std::tuple<Index, Index, int>> shapes;
  for (std::size_t l = 0; l + 1 < layers.size(); ++l)
    shapes.emplace(layers[l].weights.rows(), layers[l].weights.cols(), quantised ? quantised->layers[l].shift : 0);
  return share ? static_cast<Index>(shapes.size()) : static_cast<Index>(layers.size()) - 1;
}

/// SMLAD blocks (kernels/int16.h): 4 bytes for each of size + 2 instructions a pair of inputs, up to 32 pairs in a row
/// and what is left of them, once for each size and number of pairs.
Index int16_blocks(const QuantisedNetwork& q) {
  std::set<std::pair<Index, Index>> blocks;
  for (const QuantisedLayer& layer : q.layers) {
    const Index pairs = (layer.weights.cols() + 1) / 2, rows = padded_rows(layer.weights.rows());
    const Index fours = (5 - rows % 5) % 5;
    if (fours > 0) blocks.emplace(4, pairs);
    if (rows > 4 * fours) blocks.emplace(5, pairs);
  }
  Index bytes = 0;
  for (const auto& [size, pairs] : blocks) bytes += 4 * (size + 2) * (pairs <= 32 ? pairs : 32 + pairs % 32);
  return bytes;
}

Index code_bytes(const Model& m, const FoldedNetwork& map, const Core& core, const QuantisedNetwork* quantised) {
  const Calibration& c = quantised ? core.in_int16 : core.in_float;
  const Index hidden = hidden_layers(map.layers, core.fpu || !quantised, quantised);
  Index bytes = c.base + c.per_latent * m.nz() + c.per_layer * hidden;
  if (quantised && map.layers.size() > 1 && map.activation != Activation::kRelu) bytes += c.tanh;
  if (quantised && core.fpu) bytes += int16_blocks(*quantised);
  return !quantised && core.fpu ? bytes + float_blocks(map) : bytes;
}

Index stack_bytes(const Model& m, const FoldedNetwork& map, const Core& core, bool is_int16) {
  Index widest = is_int16 ? map.inputs() : 0;
  for (std::size_t l = 0; l + 1 < map.layers.size(); ++l) widest = std::max(widest, map.layers[l].bias.size());
  const bool one_buffer = !is_int16 && map.layers.size() <= 2;
  const Index activations = is_int16 ? 2 * 2 * (widest + 1) : (one_buffer ? 4 : 2 * 4) * widest;
  constexpr Index kPerSignal = 8;  // z, y and x_hat, copied on their way
  return (is_int16 ? core.in_int16 : core.in_float).stack + kPerSignal * (m.nz() + m.nr() + m.nx()) + activations;
}

Index amount(const std::string& key, std::string text, Index kilo) {
  const std::string all = text;
  Index unit = 1;
  if (!text.empty() && (text.back() == 'K' || text.back() == 'k')) unit = kilo;
  if (!text.empty() && text.back() == 'M') unit = kilo * kilo;
  if (unit > 1) text.pop_back();
  const double value = decimal(text) * static_cast<double>(unit);
  if (!(value >= 1.0) || value > 1e15) fail("--fit: {}={} is not an amount; write for example {}=32K", key, all, key);
  return static_cast<Index>(value);
}

}  // namespace

Budget budget(const std::string& text) {
  Budget budget;
  for (const auto& [key, value] : key_values(text, "--fit")) {
    if (key == "flash") {
      budget.flash = amount(key, value, 1024);
    } else if (key == "ram") {
      budget.ram = amount(key, value, 1024);
    } else if (key == "mac") {
      budget.multiply_adds = amount(key, value, 1000);
    } else if (key == "core") {
      budget.core = value;
      if (std::none_of(kCores.begin(), kCores.end(), [&v = value](const Core& core) { return v == core.name; }))
        fail("--fit: unknown core \"{}\"; there are m0plus, m4f, m7, m33", value);
    } else {
      fail("--fit: unknown key \"{}\"; there are flash, ram, mac, core", key);
    }
  }
  return budget;
}

std::vector<Need> needs(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const ExportOptions& options = prepared.options();
  if (!module_of(m).abilities().fit)
    fail("--fit knows structure {}, and this model is {}; build examples/firmware with it and look at its size",
         names_of_structures([](const StructureModule& s) { return s.abilities().fit; }), structure_name(m));
  if (options.scalar == ScalarType::kDouble)
    fail("--fit knows float and int16: Cortex-M cores emulate double; export with --scalar float");
  if (options.weights != WeightType::kFull)
    fail("--fit does not know what weights in {} take; leave --weights out", weight_name(options.weights));
  const FoldedNetwork& map = *prepared.folded().inverse_map();
  const QuantisedNetwork* q = prepared.quantised() == nullptr ? nullptr : &prepared.quantised()->map;
  const CppCost cost = cpp_cost(prepared);
  std::vector<Need> all;
  for (const Core& core : kCores)
    all.push_back({core.name, core.title, cost.constant_bytes, code_bytes(m, map, core, q), cost.observer_bytes,
                   stack_bytes(m, map, core, q != nullptr), cost.multiply_adds()});
  return all;
}

std::string needs_table(const std::vector<Need>& needs) {
  std::string text =
      "needs at most [bytes]\n  core   flash = constants + code    RAM = observer + stack   multiply-adds\n";
  for (const Need& need : needs)
    text += fmt::format("  {:<4} {:>7}   {:>9} + {:<5} {:>6}   {:>8} + {:<5}   {:>13}\n", need.title, need.flash(),
                        need.constants, need.code, need.ram(), need.observer, need.stack, need.multiply_adds);
  return text;
}

std::string shortfall(const std::vector<Need>& needs, const Budget& budget) {
  std::string text;
  const auto check = [&](const std::string& what, Index takes, std::optional<Index> has) {
    if (!has || takes <= *has) return;
    text += fmt::format("{}{} {} of {}, {} too many", text.empty() ? "" : "; ", what, takes, *has, takes - *has);
  };
  check("multiply-adds", needs.front().multiply_adds, budget.multiply_adds);
  for (const Need& need : needs) {
    if (!budget.core.empty() && budget.core != need.core) continue;
    check(need.title + " flash", need.flash(), budget.flash);
    check(need.title + " RAM", need.ram(), budget.ram);
  }
  if (text.empty()) return "";
  return "the model does not fit: " + text +
         ". Nothing is written; train with fewer or narrower [inverse_map] hidden layers, try the other --scalar" +
         (budget.core.empty() ? ", or name your core, as in core=m4f" : "");
}

}  // namespace nlo::codegen
