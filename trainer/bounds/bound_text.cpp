// SPDX-License-Identifier: MIT
#include "trainer/bounds/bound_text.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "trainer/base/number_text.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using Value = std::function<double(const BoundResult&)>;

/// "k = 2, 4", of the results for which `holds`; empty for none.
std::string those(const BoundReport& report, const std::function<bool(const BoundResult&)>& holds) {
  std::string text;
  for (const BoundResult& result : report.results)
    if (holds(result)) text += fmt::format("{}{}", text.empty() ? "k = " : ", ", shortest_text(result.k));
  return text;
}

std::string claim(const BoundReport& report, const char* step, bool BoundResult::*holds) {
  const std::string fails = those(report, [&](const BoundResult& r) { return !(r.*holds); });
  const char* evidence = report.exact ? "" : " (by the sampled constants)";
  return fails.empty() ? fmt::format("The proof's step {} holds for every k here{}.", step, evidence)
                       : fmt::format("The proof's step {} fails for {}{}.", step, fails, evidence);
}

}  // namespace

Table bound_table(const BoundReport& report) {
  Table table{{"", "evidence"}, {}};
  for (const BoundResult& result : report.results) table.headings.push_back("k = " + shortest_text(result.k));
  const auto row = [&](const std::string& what, const std::string& evidence, const Value& value) {
    auto& cells = table.rows.emplace_back(std::vector<std::string>{what, evidence});
    for (const BoundResult& result : report.results) cells.push_back(significant(value(result)));
  };
  const std::string bound = report.exact ? "proven" : "estimated";
  table.rows.push_back({"Constants"});
  for (std::size_t i = 0; i < report.results.front().constants.size(); ++i) {
    const BoundConstant& constant = report.results.front().constants[i];
    row(fmt::format("{}: {}", constant.symbol, constant.meaning), evidence_name(constant.evidence),
        [i](const BoundResult& r) { return r.constants[i].value; });
  }
  table.rows.push_back({"Steady error |x - x_hat|, second half of the horizon"});
  row("measured, rms", "measured", [](const BoundResult& r) { return r.measured.steady_rms; });
  row("measured, largest", "measured", [](const BoundResult& r) { return r.measured.steady_max; });
  row("measured, largest with all noise at +V or -V", "measured",
      [](const BoundResult& r) { return r.measured.offset_max; });
  if (report.exact) {
    row("bound: L of this T*, each mode at its rate", bound,
        [](const BoundResult& r) { return r.bounds.weights.steady; });
  } else {
    row("bound: slope of T* at samples", bound, [](const BoundResult& r) { return r.bounds.slopes.steady; });
    row("bound: Lipschitz constant of T* over the domain's box", bound,
        [](const BoundResult& r) { return r.bounds.box.steady; });
    row("bound: Lipschitz constant of T* from weights", bound,
        [](const BoundResult& r) { return r.bounds.weights.steady; });
  }
  row("bound (19), as printed", "claimed", [](const BoundResult& r) { return r.bounds.paper.steady; });
  table.rows.push_back({"Transient [s]: |x - x_hat| is last above a tenth of its start + eps, without noise"});
  row("that level: rms over the runs", "measured", [](const BoundResult& r) { return r.measured.transient_level; });
  row("measured, rms over the runs", "measured",
      [](const BoundResult& r) { return r.measured.transient_s.value_or(std::nan("")); });
  if (!report.exact) {
    row("bound: slope of T* at samples", bound, [](const BoundResult& r) { return r.transient_slopes_s; });
    row("bound: Lipschitz constant of T* over the domain's box", bound,
        [](const BoundResult& r) { return r.transient_box_s; });
  }
  row(report.exact ? "bound: L of this T*" : "bound: Lipschitz constant of T* from weights", bound,
      [](const BoundResult& r) { return r.transient_weights_s; });
  row("bound (19), as printed", "claimed", [](const BoundResult& r) { return r.transient_paper_s; });
  row("measured, with its own settled rms for eps", "measured",
      [](const BoundResult& r) { return r.measured.settling_s.value_or(std::nan("")); });
  table.rows.push_back({"Largest error / bound, over all runs and times"});
  if (!report.exact) {
    row("slope of T* at samples", "measured", [](const BoundResult& r) { return r.measured.ratio_slopes; });
    row("Lipschitz constant of T* over the domain's box", "measured",
        [](const BoundResult& r) { return r.measured.ratio_box; });
  }
  row(report.exact ? "L of this T*" : "Lipschitz constant of T* from weights", "measured",
      [](const BoundResult& r) { return r.measured.ratio_weights; });
  row("(19)", "measured", [](const BoundResult& r) { return r.measured.ratio_paper; });
  return table;
}

std::string broken_bound(const BoundReport& report) {
  if (!report.exact) return "";
  return those(report, [](const BoundResult& r) { return !(r.measured.ratio_weights <= 1.0); });
}

std::vector<std::string> bound_findings(const BoundReport& report) {
  std::vector<std::string> found;
  const BoundResult &slow = report.results.front(), &fast = report.results.back();
  if (report.results.size() > 1)
    found.push_back(fmt::format(
        "From k = {} to k = {} the observer settles in {} s and in {} s, and the largest steady error from {} to {}.",
        shortest_text(slow.k), shortest_text(fast.k), significant(slow.measured.settling_s, 2),
        significant(fast.measured.settling_s, 2), significant(slow.measured.steady_max, 2),
        significant(fast.measured.steady_max, 2)));
  const std::string above = those(report, [](const BoundResult& r) { return !(r.measured.ratio_slopes <= 1.0); });
  if (report.exact) {
    found.push_back(above.empty()
                        ? "Linear plant: every constant is exact, and no measurement exceeds the bound."
                        : "DEFECT: on a linear plant every constant is exact, yet the measurement exceeds the "
                          "bound for " +
                              above + ".");
  } else {
    found.push_back(
        "T_k is computed from the plant at samples: its constants are the largest found there, and bounds made of them "
        "are estimates, not proofs. The domain's box counts for as long as z and T(x) are in it.");
    if (report.affine)
      found.push_back(
          "The plant is linear but for offsets: write its states and outputs as deviations from where f and h are "
          "zero, and every constant is exact.");
    found.push_back(above.empty() ? "No measurement exceeds the estimated bound."
                                  : "The measurement exceeds the estimated bound for " + above +
                                        ": the samples have missed the worst slope of T* or its worst error.");
  }
  found.push_back(claim(report, "L_Tk <= k^n_z L_T", &BoundResult::power_claim_holds));
  bool finite = true;  // without a finite L_Tx there is no step to check
  for (const BoundConstant& c : report.results.front().constants)
    finite = finite && !(c.symbol == "L_Tx" && std::isinf(c.value));
  if (finite) found.push_back(claim(report, "L_Tkx <= L_Tx / k", &BoundResult::slope_claim_holds));
  const auto infinite = [](const BoundResult& r) { return std::isinf(r.l_tkx); };
  if (const std::string where = those(report, infinite); !where.empty())
    found.push_back(
        "L_Tkx is infinite for " + where +
        ": dT/dx grows without limit as differences get finer. D_k is slower there than the plant contracts, "
        "T is not differentiable, and the proof bounds the effect of no disturbance, however small.");
  if (!report.exact) {
    double residual = 0.0;
    for (const BoundResult& result : report.results) residual = std::max(residual, result.pde_residual);
    found.push_back(fmt::format("T_k solves its equation (5) to {} of the size of its terms, at the initial states.",
                                significant(residual, 2)));
    std::string maps;
    for (const BoundResult& result : report.results)
      maps += fmt::format("{}k = {} {}", maps.empty() ? "" : "; ", shortest_text(result.k), result.inverse_map);
    found.push_back("T*: " + maps + ".");
  }
  return found;
}

std::string bound_conditions(const BoundReport& report) {
  return fmt::format("noise |v_j| <= {:.4g} per sample, disturbance |w| <= {}, {} runs of {} s, seed {}",
                     report.test.noise, shortest_text(report.test.disturbance), report.test.trajectories,
                     significant(report.horizon_s, 2), report.test.seed);
}

std::string bound_text(const BoundReport& report) {
  constexpr std::size_t kOneTable = 400;  // columns: values of k are compared line by line, however many there are
  std::string result = fmt::format("{} on {}: Proposition 2 with D_k = k D\n{}\n\n{}\n", report.model, report.plant,
                                   bound_conditions(report), bound_table(report).to_text(2, kOneTable));
  for (const std::string& finding : bound_findings(report)) result += finding + "\n";
  return result;
}

std::string bound_csv(const BoundReport& report) {
  std::string csv = "k,inverse_map";
  for (const BoundConstant& constant : report.results.front().constants) {
    std::string name = constant.symbol;
    for (char& c : name)
      if (c == ' ') c = '_';
    csv += "," + name;
  }
  csv +=
      ",measured_steady_rms,measured_steady_max,measured_offset_max,measured_transient_s,measured_settling_s,bound_"
      "weights_steady,"
      "bound_box_steady,bound_slopes_steady,bound_19_steady,transient_level,bound_weights_transient_s,"
      "bound_box_transient_s,bound_slopes_transient_s,bound_19_transient_s,ratio_weights,ratio_box,ratio_slopes,"
      "ratio_19\n";
  for (const BoundResult& r : report.results) {
    csv += fmt::format("{},\"{}\"", shortest_text(r.k), r.inverse_map);
    const auto add = [&](double value) { csv += "," + (std::isnan(value) ? std::string() : shortest_text(value)); };
    for (const BoundConstant& constant : r.constants) add(constant.value);
    const BoundMeasurement& m = r.measured;
    for (const double value :
         {m.steady_rms, m.steady_max, m.offset_max, m.transient_s.value_or(std::nan("")),
          m.settling_s.value_or(std::nan("")), r.bounds.weights.steady, r.bounds.box.steady, r.bounds.slopes.steady,
          r.bounds.paper.steady, m.transient_level, r.transient_weights_s, r.transient_box_s, r.transient_slopes_s,
          r.transient_paper_s, m.ratio_weights, m.ratio_box, m.ratio_slopes, m.ratio_paper})
      add(value);
    csv += "\n";
  }
  return csv;
}

}  // namespace nlo::trainer
