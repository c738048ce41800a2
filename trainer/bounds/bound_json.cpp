// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "trainer/base/noise.h"
#include "trainer/bounds/bound_text.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json bound_of(const ErrorBound& bound, double transient_s, double ratio) {
  return {{"gain", number(bound.gain)},
          {"rate_per_s", number(bound.rate)},
          {"steady", number(bound.steady)},
          {"transient_s", number(transient_s)},
          {"largest_error_over_bound", number(ratio)}};
}

Json result_json(const BoundResult& r) {
  const BoundMeasurement& m = r.measured;
  Json json = {{"k", r.k}, {"inverse_map", r.inverse_map}};
  for (const BoundConstant& constant : r.constants)
    json["constants"].push_back({{"symbol", constant.symbol},
                                 {"value", number(constant.value)},
                                 {"evidence", evidence_name(constant.evidence)},
                                 {"meaning", constant.meaning}});
  json["bounds"] = {{"paper_19", bound_of(r.bounds.paper, r.transient_paper_s, m.ratio_paper)},
                    {"weights", bound_of(r.bounds.weights, r.transient_weights_s, m.ratio_weights)},
                    {"box", bound_of(r.bounds.box, r.transient_box_s, m.ratio_box)},
                    {"slopes", bound_of(r.bounds.slopes, r.transient_slopes_s, m.ratio_slopes)}};
  json["measured"] = {{"steady_rms", number(m.steady_rms)},
                      {"steady_max", number(m.steady_max)},
                      {"offset_max", number(m.offset_max)},
                      {"quiet_rms", number(m.quiet_rms)},
                      {"transient_level", number(m.transient_level)},
                      {"transient_s", m.transient_s ? number(*m.transient_s) : Json(nullptr)},
                      {"settling_s", m.settling_s ? number(*m.settling_s) : Json(nullptr)}};
  json["proof_steps"] = {{"L_Tk <= k^n_z L_T", r.power_claim_holds}, {"L_Tkx <= L_Tx / k", r.slope_claim_holds}};
  json["pde_residual"] = number(r.pde_residual);
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
  return json.dump(2) + "\n";
}

}  // namespace nlo::trainer
