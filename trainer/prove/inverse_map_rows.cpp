// SPDX-License-Identifier: MIT
// Rows about the inverse map T*: bounds of its slopes and of its estimates.
#include <fmt/format.h>

#include <string>

#include "trainer/judge/evaluation/text.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/lipschitz.h"
#include "trainer/prove/output_range.h"

namespace nlo::trainer {
namespace {

/// This work takes about a minute of one core, unless the gap is reached earlier.
constexpr double kMultiplyAddsOfARow = 50.0 * LocalLipschitzOptions::kMultiplyAdds;

/// Returns a text such as "at [z; y] = [0.1, 2]".
std::string place_text(const Eigen::VectorXd& at) {
  std::string text;
  for (const double value : at) text += fmt::format("{}{}", text.empty() ? "" : ", ", significant(value, 4));
  return fmt::format("at [z; y] = [{}]", text);
}

}  // namespace

std::string reason_against_map(const codegen::Model& model) {
  const codegen::Network* map = codegen::inverse_map(model);
  if (map == nullptr) return "z itself is the estimate, so there is no T*";
  if (!map->feature_clocks.empty())
    return "T* reads products of z with clocks (clock_products), but the proofs need features that are linear in z";
  if (!map->fallback.outputs.empty())
    return "T* can fall back to linear rows, but the proofs need a pure network: train without [inverse_map] fallback";
  return {};
}

CertificateRows lipschitz_rows(const codegen::Model& model, const CertifyOptions& options) {
  if (const std::string why = reason_against_map(model); !why.empty())
    return {absent_row("lipschitz", "a slope of T*", why)};
  CertificateRows rows;
  const LipschitzConstants everywhere = lipschitz_upper(model);
  for (const bool of_output : {false, true}) {
    const char* id = of_output ? "lipschitz_y" : "lipschitz";
    const char* of = of_output ? "y" : "z";
    const double global = of_output ? everywhere.output : everywhere.latent;
    if (global == 0.0) {
      rows.push_back(absent_row(id, fmt::format("|d x_hat / d {}|", of), "T* does not read y"));
      continue;
    }
    LocalLipschitzOptions search{.boxes = options.boxes, .gap = options.gap};
    search.multiply_adds = kMultiplyAddsOfARow;
    const LocalLipschitz local = local_lipschitz(model, of_output, search);
    CertificateRow row;
    row.id = id;
    row.what = fmt::format("|d x_hat / d {}| over the domain", of);
    row.unit = "units of x_hat";
    row.bound = local.bound;
    row.found = local.found;
    row.where = place_text(local.steepest);
    row.note = fmt::format("{} boxes examined", local.boxes);
    rows.push_back(row);
    row.id += "_everywhere";
    row.what = fmt::format("|d x_hat / d {}| for all z and y", of);
    row.bound = global;
    row.note = "from the weights";
    rows.push_back(std::move(row));
  }
  return rows;
}

CertificateRows estimate_rows(const codegen::Model& model, const CertifyOptions& options) {
  constexpr std::int64_t kBoxes = 20000;
  constexpr const char* kWhat = "|x_hat| of T* for every reachable z";
  if (const std::string why = reason_against_map(model); !why.empty()) return {absent_row("estimate", kWhat, why)};
  const auto region = reachable_region(model);
  if (!region)
    return {absent_row("estimate", kWhat,
                       fmt::format("no bound of z is known for structure {}", codegen::structure_name(model)))};
  CertificateRows rows;
  for (Eigen::Index i = 0; i < model.nx(); ++i) {
    const codegen::Channel& state = model.states[static_cast<std::size_t>(i)];
    const LargestOutput largest =
        largest_output(model, *region, i, options.boxes > 0 ? options.boxes : kBoxes, options.gap, options.seed);
    CertificateRow row;
    row.id = "estimate." + state.name;
    row.what = fmt::format("|{}| of T* for every reachable z{}", state.name,
                           model.saturates() ? ", saturated as T* reads it" : "");
    row.unit = state.unit;
    row.bound = largest.bound;
    row.found = largest.found;
    row.where = place_text(largest.where);
    row.note = fmt::format("over a box that contains every reachable z; {} boxes examined", largest.boxes);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace nlo::trainer
