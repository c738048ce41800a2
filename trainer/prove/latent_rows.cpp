// SPDX-License-Identifier: MIT
// Rows about the latent state: its reachable set, and how fast it forgets its initial value.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "codegen/structures/structure_module.h"
#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/reachable_latent.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Returns the largest |factor| of a mode per step, rounded up.
double largest_factor(const codegen::Model& m) {
  const codegen::StepMatrices step = codegen::latent_step(m, m.sample_period_s);
  double largest = 0.0;
  for (Index r = 0; r < m.nz();) {
    const bool pair = r < 2 * codegen::linear_latent(m)->pairs;
    const double re = 1.0 + step.a_minus_1(r), im = pair ? step.a_minus_1(r + 1) : 0.0;
    largest = std::max(largest, upward(std::sqrt(re * re + im * im), 4));
    r += pair ? 2 : 1;
  }
  return largest;
}

/// Returns "1.38 s (69 steps)": the time in which a difference that shrinks by `factor` per step falls to a thousandth.
std::string time_to_a_thousandth(double factor, double period_s) {
  const double steps = std::ceil(std::log(1e-3) / std::log(factor));
  return fmt::format("a difference falls to a thousandth within {} s, {:.0f} steps", significant(steps * period_s),
                     steps);
}

/// Draws z in the domain and readings in their ranges.
struct LatentDraws {
  const codegen::Model& m;
  std::mt19937_64 engine;

  double within(double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; }
  VectorXd box(const VectorXd& low, const VectorXd& high) {
    return VectorXd::NullaryExpr(low.size(), [&](Index i) { return within(low(i), high(i)); });
  }
  VectorXd z() { return box(m.latent_min, m.latent_max); }
  VectorXd y() { return box(codegen::flown_ranges(m).kept_min, codegen::flown_ranges(m).kept_max); }
};

/// Returns the largest growth of max |dz_i| / d_i over one step at random points: central differences along each
/// coordinate, summed row by row.
double largest_growth(const codegen::Model& m, const VectorXd& metric, std::uint64_t seed, std::string& where) {
  constexpr int kDraws = 2000;
  constexpr double kDifference = 1e-5;
  const auto dynamics = codegen::module_of(m).dynamics_in_double(m, codegen::Activations::kExact);
  LatentDraws draws{m, std::mt19937_64(seed)};
  const VectorXd none = VectorXd::Zero(0);
  double largest = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const VectorXd z = draws.z(), y = draws.y(), y_next = draws.y();
    VectorXd sums = VectorXd::Zero(m.nz());
    for (Index k = 0; k < m.nz(); ++k) {
      VectorXd ahead = z, behind = z;
      ahead(k) += kDifference;
      behind(k) -= kDifference;
      dynamics->advance(ahead, {y, y_next, none, none}, m.sample_period_s);
      dynamics->advance(behind, {y, y_next, none, none}, m.sample_period_s);
      sums += ((ahead - behind) / (2.0 * kDifference)).cwiseAbs() * metric(k);
    }
    const double growth = sums.cwiseQuotient(metric).maxCoeff();
    if (growth <= largest) continue;
    largest = growth;
    where = fmt::format("at draw {} of z in its domain and readings in their ranges", i);
  }
  return largest;
}

/// Returns a row for all gated units, and one for each other coordinate.
CertificateRows limit_rows(const codegen::Model& model, const VectorXd& limit) {
  const Index units = codegen::module_of(model).gated_units(model);
  CertificateRows rows;
  if (units > 0) {
    CertificateRow row;
    row.id = "latent";
    row.what = "largest |z_i| of all units for any measurements";
    row.bound = limit.head(units).maxCoeff();
    row.note = "proven from the equations: each unit moves towards a value within the bound and never past it";
    rows.push_back(std::move(row));
  }
  for (Index i = units; i < limit.size(); ++i) {
    CertificateRow row;
    row.id = fmt::format("latent.z{}", i + 1);
    row.what = fmt::format("|z{}| for any measurements", i + 1);
    row.bound = limit(i);
    row.note = "each step limits this coordinate to the range in the model file";
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

CertificateRows latent_rows(const codegen::Model& model, const CertifyOptions&) {
  constexpr const char* kWhat = "reachable z for any measurements";
  const auto limit = codegen::module_of(model).latent_limit(model);
  if (limit) return limit_rows(model, *limit);
  if (!moves_linearly(model))
    return {absent_row(
        "latent", kWhat,
        fmt::format("no bound is computed for structure {}: its equations keep z finite, and the export checks this",
                    codegen::structure_name(model)))};
  const LatentHull hull = reachable_latent(model), reached = reached_latent(model);
  const VectorXd middle = hull.middle();
  CertificateRows rows;
  for (Index i = 0; i < model.nz(); ++i) {
    CertificateRow row;
    row.id = fmt::format("latent.z{}", i + 1);
    row.what = fmt::format("|z{} - {}| for any readings", i + 1, shortest_text(middle(i)));
    row.bound = upward(std::max(hull.high(i) - middle(i), middle(i) - hull.low(i)), 1);
    row.found = std::max(reached.high(i) - middle(i), middle(i) - reached.low(i));
    row.where = "with readings at the ends of their ranges, chosen by the sign of their effect on this coordinate";
    row.note = fmt::format("z stays in [{}, {}]; training covered [{}, {}]", significant(hull.low(i), 4),
                           significant(hull.high(i), 4), significant(model.latent_min(i), 4),
                           significant(model.latent_max(i), 4));
    rows.push_back(std::move(row));
  }
  return rows;
}

CertificateRows contraction_rows(const codegen::Model& model, const CertifyOptions& options) {
  CertificateRow row;
  row.id = "contraction";
  row.what = "factor by which one step with the same readings shrinks the difference of two z";
  if (moves_linearly(model)) {
    row.bound = largest_factor(model);
    const codegen::StepMatrices step = codegen::latent_step(model, model.sample_period_s);
    const Eigen::MatrixXd a =
        Eigen::MatrixXd::Identity(model.nz(), model.nz()) + codegen::block_diagonal(model, step.a_minus_1);
    std::mt19937_64 engine(options.seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 1000; ++i) {  // after many steps, only the slowest mode is left
      VectorXd d = VectorXd::NullaryExpr(model.nz(), [&] { return normal(engine); });
      for (int k = 0; k < 20; ++k) {
        const VectorXd next = a * d;
        row.found = std::max(std::isnan(row.found) ? 0.0 : row.found, next.norm() / d.norm());
        d = next;
      }
    }
    row.where = "with random differences over 20 steps each";
    row.note =
        "in the Euclidean norm of z; proven, because a step multiplies the difference by A, whose blocks are normal; " +
        time_to_a_thousandth(row.bound, model.sample_period_s);
    return {row};
  }
  const auto known = codegen::module_of(model).contraction(model);
  if (!known)
    return {
        absent_row(row.id, row.what,
                   fmt::format("no proof of contraction is known for structure {}", codegen::structure_name(model)))};
  const codegen::Contraction& proof = *known;
  const VectorXd metric = proof.none() ? VectorXd(VectorXd::Ones(model.nz())) : proof.metric;
  row.found = largest_growth(model, metric, options.seed, row.where);
  if (proof.none()) {
    row.note = "not proven: the gates depend on z so strongly that no bound below 1 follows; found in the maximum norm";
    return {row};
  }
  constexpr double kRounding = 1e-9;  // bounds the rounding of a sum of about n_z terms below 1
  row.bound = std::exp(-proof.rate * model.sample_period_s) + kRounding;
  row.note = "in the maximum norm of z_i / d_i, where the weights determine d (codegen/model/contraction.h); " +
             time_to_a_thousandth(row.bound, model.sample_period_s);
  return {row};
}

}  // namespace nlo::trainer
