// SPDX-License-Identifier: MIT
// The certificate of a model: each row exists for each structure, no search finds a value above its bound, and a bound
// that is too small is detected.
#include "trainer/prove/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>

#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/structures/structure_module.h"
#include "tests/codegen/example_models.h"

namespace nlo::trainer {
namespace {

using codegen::Model;
using testing::HasSubstr;
using testing::IsEmpty;

CertifyOptions quick() {
  CertifyOptions options;
  options.boxes = 200;
  return options;
}

const CertificateRow& row_of(const Certificate& certificate, const std::string& id) {
  for (const CertificateRow& row : certificate.rows)
    if (row.id == id) return row;
  throw std::runtime_error("no row " + id);
}

TEST(Certificate, NoSearchFindsAValueAboveABound) {
  for (const Model& model : codegen::example_models()) {
    const Certificate certificate = certify(model, quick());
    EXPECT_THAT(broken_rows(certificate), IsEmpty()) << model.name;
    std::set<std::string> ids;
    for (const CertificateRow& row : certificate.rows) {
      EXPECT_TRUE(ids.insert(row.id).second) << model.name << ": " << row.id << " is listed twice";
      EXPECT_TRUE(!std::isnan(row.bound) || !row.note.empty())
          << model.name << ": " << row.id << " has neither a bound nor a note";
    }
  }
}

TEST(Certificate, ControlABoundThatIsTooSmallIsDetected) {
  Certificate certificate = certify(codegen::tiny_model(), quick());
  for (CertificateRow& row : certificate.rows) {
    if (std::isnan(row.bound) || !(row.found > 0.0)) continue;
    const double bound = row.bound;
    row.bound = 0.5 * row.found;
    EXPECT_THAT(broken_rows(certificate), HasSubstr(row.id));
    row.bound = bound;
  }
  EXPECT_THAT(broken_rows(certificate), IsEmpty());
}

TEST(Certificate, ContractionOfALinearLatentSystemIsThatOfItsSlowestMode) {
  const Model model = codegen::tiny_model();
  const Certificate certificate = certify(model, quick());
  const double slowest = codegen::linear_latent(model)->eigenvalues.maxCoeff();
  const CertificateRow& row = row_of(certificate, "contraction");
  EXPECT_GE(row.bound, std::exp(slowest * model.sample_period_s));
  EXPECT_NEAR(row.bound, std::exp(slowest * model.sample_period_s), 1e-12);
  EXPECT_NEAR(row.found, row.bound, 1e-3);
}

TEST(Certificate, GatedUnitsHaveARateIfTheirWeightsProveOne) {
  const CertificateRow proven = row_of(certify(codegen::contracting_gated_model(), quick()), "contraction");
  EXPECT_LT(proven.bound, 1.0);
  EXPECT_GT(proven.found, 0.0);
  EXPECT_LE(proven.found, proven.bound);
  const CertificateRow open = row_of(certify(codegen::gated_model(), quick()), "contraction");
  EXPECT_TRUE(std::isnan(open.bound));
  EXPECT_THAT(open.note, HasSubstr("not proven"));
}

TEST(Certificate, StatesAndCovarianceOfAPriorStayWithinTheirBoundsForReadingsAtTheEndsOfTheirRanges) {
  const Model model = codegen::prior_model();
  const Certificate certificate = certify(model, quick());
  const Eigen::Index units = codegen::module_of(model).gated_units(model);
  Eigen::VectorXd bound = Eigen::VectorXd::Constant(model.nz(), row_of(certificate, "latent").bound);
  for (Eigen::Index i = units; i < model.nz(); ++i)
    bound(i) = row_of(certificate, "latent.z" + std::to_string(i + 1)).bound;
  std::mt19937_64 engine(1);
  codegen::ReferenceObserver<double> observer(model);
  double fullest = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const auto end = [&](const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
      return Eigen::VectorXd(low.binaryExpr(high, [&](double a, double b) { return engine() % 2 == 0 ? a : b; }));
    };
    observer.step(end(model.output_min, model.output_max), end(model.input_min, model.input_max));
    const Eigen::VectorXd share = observer.latent().cwiseAbs().cwiseQuotient(bound);
    ASSERT_LE(share.maxCoeff(), 1.0 + 1e-12) << "sample " << k;  // rounding of the quotient
    fullest = std::max(fullest, share.maxCoeff());
  }
  EXPECT_EQ(fullest, 1.0) << "the readings never pushed a state to its limit, so this test could not fail";
  for (const codegen::Channel& state : model.states)
    EXPECT_TRUE(std::isfinite(row_of(certificate, "estimate." + state.name).bound)) << state.name;
}

TEST(Certificate, LipschitzConstantOfTheShippedModelIsWithinThirtyPerCentOfTheSteepestSlope) {
  const Model model = codegen::read_model(std::string(NLO_SOURCE_DIR) + "/examples/models/van_der_pol.json");
  CertifyOptions options;  // takes one or two minutes; a default run takes less
  options.gap = 0.3;
#ifndef NLO_SLOW
  options.boxes = 100000;
#endif
  const Certificate certificate{model.name, "", lipschitz_rows(model, options), {}};
  const CertificateRow& row = row_of(certificate, "lipschitz");
#ifdef NLO_SLOW
  EXPECT_LE(row.bound, 1.3 * row.found);
#else
  EXPECT_LE(row.bound, 1.65 * row.found);
#endif
  EXPECT_GE(row.bound, row.found);
}

TEST(Certificate, JsonHasEveryRowAndNullForAMissingBound) {
  const Certificate certificate = certify(codegen::luenberger_model(), quick());
  const auto json = nlohmann::json::parse(certificate_json(certificate));
  ASSERT_EQ(json["rows"].size(), certificate.rows.size());
  for (std::size_t i = 0; i < certificate.rows.size(); ++i) {
    EXPECT_EQ(json["rows"][i]["id"], certificate.rows[i].id);
    EXPECT_EQ(json["rows"][i]["bound"].is_null(), std::isnan(certificate.rows[i].bound));
  }
  EXPECT_THAT(certificate_text(certificate), HasSubstr("there is no T*"));
}

}  // namespace
}  // namespace nlo::trainer
