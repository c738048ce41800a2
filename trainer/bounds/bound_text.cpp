// SPDX-License-Identifier: MIT
#include "trainer/bounds/bound_text.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>
#include <string_view>

#include "trainer/base/noise.h"
#include "trainer/base/number_text.h"
#include "trainer/evaluation/json_numbers.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using Value = std::function<double(const BoundResult&)>;

/// How a bound is called: in the table, and where all its constants are exact ("" where it is left out), and as a key.
struct BoundWords {
  BoundKind kind;
  std::string_view name, exact_name, key;
};
constexpr BoundWords kBounds[] = {
    {kSlopesBound, "slope of T* at samples", "", "slopes"},
    {kBoxBound, "Lipschitz constant of T* over the domain's box", "", "box"},
    {kWeightsBound, "Lipschitz constant of T* from weights", "L of this T*, each mode at its rate", "weights"},
    {kPaperBound, "(19)", "(19)", "19"}};

/// What was measured, as a key.
struct Measured {
  const char* key;
  double (*value)(const BoundMeasurement&);
};
constexpr Measured kMeasured[] = {
    {"steady_rms", [](const BoundMeasurement& m) { return m.steady_rms; }},
    {"steady_max", [](const BoundMeasurement& m) { return m.steady_max; }},
    {"offset_max", [](const BoundMeasurement& m) { return m.offset_max; }},
    {"quiet_rms", [](const BoundMeasurement& m) { return m.quiet_rms; }},
    {"transient_level", [](const BoundMeasurement& m) { return m.transient_level; }},
    {"transient_s", [](const BoundMeasurement& m) { return m.transient_s.value_or(std::nan("")); }},
    {"settling_s", [](const BoundMeasurement& m) { return m.settling_s.value_or(std::nan("")); }}};

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
  const auto measured = [&](const std::string& what, double (*value)(const BoundMeasurement&)) {
    row(what, "measured", [value](const BoundResult& r) { return value(r.measured); });
  };
  /// A row for each bound: of "bound: its name" or, of a comparison with one, of the name alone.
  const auto of_bounds = [&](bool compared, const std::function<double(const BoundResult&, BoundKind)>& value) {
    for (const BoundWords& words : kBounds) {
      const std::string_view name = report.exact ? words.exact_name : words.name;
      if (name.empty()) continue;
      const bool paper = words.kind == kPaperBound;
      row(compared ? std::string(name)
          : paper  ? "bound (19), as printed"
                   : fmt::format("bound: {}", name),
          compared       ? "measured"
          : paper        ? "claimed"
          : report.exact ? "proven"
                         : "estimated",
          [&value, kind = words.kind](const BoundResult& r) { return value(r, kind); });
    }
  };
  table.rows.push_back({"Constants"});
  for (std::size_t i = 0; i < report.results.front().constants.size(); ++i) {
    const BoundConstant& constant = report.results.front().constants[i];
    row(fmt::format("{}: {}", constant.symbol, constant.meaning), evidence_name(constant.evidence),
        [i](const BoundResult& r) { return r.constants[i].value; });
  }
  table.rows.push_back({"Steady error |x - x_hat|, second half of the horizon"});
  measured("measured, rms", [](const BoundMeasurement& m) { return m.steady_rms; });
  measured("measured, largest", [](const BoundMeasurement& m) { return m.steady_max; });
  measured("measured, largest with all noise at +V or -V", [](const BoundMeasurement& m) { return m.offset_max; });
  of_bounds(false, [](const BoundResult& r, BoundKind kind) { return r.bounds[kind].steady; });
  table.rows.push_back({"Transient [s]: |x - x_hat| is last above a tenth of its start + eps, without noise"});
  measured("that level: rms over the runs", [](const BoundMeasurement& m) { return m.transient_level; });
  measured("measured, rms over the runs",
           [](const BoundMeasurement& m) { return m.transient_s.value_or(std::nan("")); });
  of_bounds(false, [](const BoundResult& r, BoundKind kind) { return r.transient_s[kind]; });
  measured("measured, with its own settled rms for eps",
           [](const BoundMeasurement& m) { return m.settling_s.value_or(std::nan("")); });
  table.rows.push_back({"Largest error / bound, over all runs and times"});
  of_bounds(true, [](const BoundResult& r, BoundKind kind) { return r.measured.ratio[kind]; });
  return table;
}

std::string broken_bound(const BoundReport& report) {
  if (!report.exact) return "";
  return those(report, [](const BoundResult& r) { return !(r.measured.ratio[kWeightsBound] <= 1.0); });
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
  const std::string above =
      those(report, [](const BoundResult& r) { return !(r.measured.ratio[kSlopesBound] <= 1.0); });
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
  for (const Measured& measured : kMeasured) csv += fmt::format(",measured_{}", measured.key);
  for (const BoundWords& bound : kBounds)
    csv += fmt::format(",bound_{0}_steady,bound_{0}_transient_s,ratio_{0}", bound.key);
  csv += "\n";
  for (const BoundResult& r : report.results) {
    csv += fmt::format("{},\"{}\"", shortest_text(r.k), r.inverse_map);
    const auto add = [&](double value) { csv += "," + (std::isnan(value) ? std::string() : shortest_text(value)); };
    for (const BoundConstant& constant : r.constants) add(constant.value);
    for (const Measured& measured : kMeasured) add(measured.value(r.measured));
    for (const BoundWords& bound : kBounds)
      for (const double value : {r.bounds[bound.kind].steady, r.transient_s[bound.kind], r.measured.ratio[bound.kind]})
        add(value);
    csv += "\n";
  }
  return csv;
}

namespace {

Json result_json(const BoundResult& r) {
  Json json = {{"k", r.k}, {"inverse_map", r.inverse_map}};
  for (const BoundConstant& constant : r.constants)
    json["constants"].push_back({{"symbol", constant.symbol},
                                 {"value", json_number(constant.value)},
                                 {"evidence", evidence_name(constant.evidence)},
                                 {"meaning", constant.meaning}});
  for (const BoundWords& words : kBounds) {
    const ErrorBound& bound = r.bounds[words.kind];
    json["bounds"][words.kind == kPaperBound ? "paper_19" : std::string(words.key)] = {
        {"gain", json_number(bound.gain)},
        {"rate_per_s", json_number(bound.rate)},
        {"steady", json_number(bound.steady)},
        {"transient_s", json_number(r.transient_s[words.kind])},
        {"largest_error_over_bound", json_number(r.measured.ratio[words.kind])}};
  }
  for (const Measured& measured : kMeasured) json["measured"][measured.key] = json_number(measured.value(r.measured));
  json["proof_steps"] = {{"L_Tk <= k^n_z L_T", r.power_claim_holds}, {"L_Tkx <= L_Tx / k", r.slope_claim_holds}};
  json["pde_residual"] = json_number(r.pde_residual);
  return json;
}

}  // namespace

std::string bound_json(const BoundReport& report) {
  Json json = {{"model", report.model},
               {"plant", report.plant},
               {"exact", report.exact},
               {"noise", format_noise(NoiseConfig{NoiseKind::kUniform, report.test.noise})},
               {"disturbance", report.test.disturbance},
               {"trajectories", report.test.trajectories},
               {"horizon_s", report.horizon_s},
               {"seed", report.test.seed},
               {"results", Json::array()},
               {"findings", bound_findings(report)}};
  for (const BoundResult& result : report.results) json["results"].push_back(result_json(result));
  return json_text(json) + "\n";
}

}  // namespace nlo::trainer
