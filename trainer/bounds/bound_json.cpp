// SPDX-License-Identifier: MIT
#include <optional>

#include "trainer/base/noise.h"
#include "trainer/bounds/bound_text.h"
#include "trainer/evaluation/json_numbers.h"

namespace nlo::trainer {
namespace {

Json bound_of(const ErrorBound& bound, double transient_s, double ratio) {
  return {{"gain", json_number(bound.gain)},
          {"rate_per_s", json_number(bound.rate)},
          {"steady", json_number(bound.steady)},
          {"transient_s", json_number(transient_s)},
          {"largest_error_over_bound", json_number(ratio)}};
}

Json result_json(const BoundResult& r) {
  const BoundMeasurement& m = r.measured;
  Json json = {{"k", r.k}, {"inverse_map", r.inverse_map}};
  for (const BoundConstant& constant : r.constants)
    json["constants"].push_back({{"symbol", constant.symbol},
                                 {"value", json_number(constant.value)},
                                 {"evidence", evidence_name(constant.evidence)},
                                 {"meaning", constant.meaning}});
  json["bounds"] = {{"paper_19", bound_of(r.bounds.paper, r.transient_paper_s, m.ratio_paper)},
                    {"weights", bound_of(r.bounds.weights, r.transient_weights_s, m.ratio_weights)},
                    {"box", bound_of(r.bounds.box, r.transient_box_s, m.ratio_box)},
                    {"slopes", bound_of(r.bounds.slopes, r.transient_slopes_s, m.ratio_slopes)}};
  json["measured"] = {{"steady_rms", json_number(m.steady_rms)},
                      {"steady_max", json_number(m.steady_max)},
                      {"offset_max", json_number(m.offset_max)},
                      {"quiet_rms", json_number(m.quiet_rms)},
                      {"transient_level", json_number(m.transient_level)},
                      {"transient_s", m.transient_s ? json_number(*m.transient_s) : Json(nullptr)},
                      {"settling_s", m.settling_s ? json_number(*m.settling_s) : Json(nullptr)}};
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
