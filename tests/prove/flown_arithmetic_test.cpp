// SPDX-License-Identifier: MIT
// The proven error of the exported arithmetic, compared with the runtime itself: exported headers of the shipped model
// in float (both policies), with bf16 weights and in int16.
#include <gtest/gtest.h>
#include <vdp_bf16.h>
#include <vdp_float.h>
#include <vdp_int16.h>

#include <cmath>
#include <random>
#include <string>

#include "codegen/model/domain.h"
#include "codegen/model_file/model_file.h"
#include "codegen/reference/reference_network.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/targets/number_formats.h"
#include "tests/codegen/example_models.h"
#include "trainer/prove/arithmetic_error.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/flown_map.h"
#include "trainer/prove/output_range.h"

namespace nlo::trainer {
namespace {

using codegen::Model;
using Eigen::Index;

Model shipped_model() {
  return codegen::read_model(std::string(NLO_SOURCE_DIR) + "/examples/models/van_der_pol.json");
}

/// Returns the proven bounds of its two estimates in a format, from few boxes.
Eigen::Vector2d proven_error(const Model& model, const std::string& format) {
  CertifyOptions options;
  options.boxes = 500;
  Eigen::Vector2d bound = Eigen::Vector2d::Zero();
  for (const CertificateRow& row : arithmetic_rows(model, options))
    for (int i = 0; i < 2; ++i)
      if (row.id == "arithmetic." + format + (i == 0 ? ".x1" : ".x2")) bound(i) = row.bound;
  return bound;
}

/// Returns the largest |flown T* - real T*| over floats in the domain, including its corners.
template <Arithmetic kArithmetic, class Flown>
Eigen::Vector2d largest_at_draws(const Model& model, const Flown& flown) {
  const codegen::ReferenceNetwork<double> exact(*codegen::inverse_map(model));
  const MapRegion region = domain_region(model);
  std::mt19937_64 engine(5);
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  for (int k = 0; k < 40000; ++k) {
    Eigen::VectorXd q = Eigen::VectorXd::NullaryExpr(region.box.centre.size(), [&] {
      const double u = static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0;
      return 0.999999 * (k % 3 == 0 ? std::copysign(1.0, u) : u);
    });
    const Eigen::VectorXf in = (region.box.centre + region.box.radius.cwiseProduct(q)).cast<float>();
    float z[6], y[1] = {in(6)}, x_hat[2];
    for (int i = 0; i < 6; ++i) z[i] = in(i);
    flown.template estimate<kArithmetic>(z, y, x_hat);
    const Eigen::VectorXd real = exact(in.cast<double>());
    for (int i = 0; i < 2; ++i) largest(i) = std::max(largest(i), std::abs(static_cast<double>(x_hat[i]) - real(i)));
  }
  return largest;
}

/// Returns the largest difference in whole flights with constant readings, while z is in its domain.
template <class Observer, class Flown>
Eigen::Vector2d largest_in_flights(const Model& model, const Flown& flown) {
  codegen::ReferenceObserver<double> exact(model);
  const codegen::LatentDomain domain(model);
  std::mt19937_64 engine(9);
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  int compared = 0;
  for (int run = 0; run < 60; ++run) {
    Observer observer(flown);
    exact.reset();
    float y = 0.0F;
    for (int k = 0; k < 1200; ++k) {
      if (k % 300 == 0)
        y = static_cast<float>((run % 6 + 1) * 0.02 * (static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0));
      (void)observer.step(y);
      exact.step(Eigen::VectorXd::Constant(1, static_cast<double>(y)));
      if (!domain.contains(exact.latent(), exact.output())) break;
      ++compared;
      const auto x_hat = observer.estimate();
      const Eigen::VectorXd real = exact.estimate();
      for (int i = 0; i < 2; ++i) largest(i) = std::max(largest(i), std::abs(static_cast<double>(x_hat[i]) - real(i)));
    }
  }
  EXPECT_GT(compared, 10000);
  return largest;
}

template <Arithmetic kArithmetic, class Flown>
Eigen::Vector2d largest_flown(const Model& model, const Flown& flown) {
  using Observer = KklObserver<Flown, kArithmetic>;
  return largest_at_draws<kArithmetic>(model, flown).cwiseMax(largest_in_flights<Observer>(model, flown));
}

TEST(FlownArithmetic, ErrorOfTheRuntimeIsWithinItsProof) {
  const Model model = shipped_model();
  const auto check = [&](const std::string& format, const Eigen::Vector2d& found, double loosest) {
    const Eigen::Vector2d bound = proven_error(model, format);
    for (int i = 0; i < 2; ++i) {
      EXPECT_LE(found(i), bound(i)) << format << " x" << i + 1;
      EXPECT_LE(bound(i), loosest * found(i)) << format << " x" << i + 1 << ": the bound is too loose";
    }
  };
  check("float", largest_flown<Arithmetic::kFast>(model, vdp_float::kModel), 2000.0);
  check("float", largest_flown<Arithmetic::kDeterministic>(model, vdp_float::kModel), 2000.0);
  check("bf16", largest_flown<Arithmetic::kFast>(model, vdp_bf16::kModel), 30.0);
  check("bf16", largest_flown<Arithmetic::kDeterministic>(model, vdp_bf16::kModel), 30.0);
  check("int16", largest_flown<Arithmetic::kDeterministic>(model, vdp_int16::kModel), 40.0);
}

TEST(FlownArithmetic, ControlTheProofOfAnotherFormatIsBroken) {
  const Model model = shipped_model();
  const Eigen::Vector2d of_float = proven_error(model, "float"), of_int16 = proven_error(model, "int16");
  const Eigen::Vector2d int16 = largest_flown<Arithmetic::kDeterministic>(model, vdp_int16::kModel);
  const Eigen::Vector2d bf16 = largest_flown<Arithmetic::kDeterministic>(model, vdp_bf16::kModel);
  EXPECT_GT((int16 - of_float).maxCoeff(), 0.0);
  EXPECT_GT((bf16 - of_int16).maxCoeff(), 0.0);
}

TEST(FlownArithmetic, ControlAProofWithoutTheWeightsErrorIsBroken) {
  const Model model = shipped_model();
  const MapRegion region = domain_region(model);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(region.inputs.rows(), region.inputs.rows());
  const JacobianEnclosure real(*codegen::inverse_map(model), identity, identity);
  codegen::ExportOptions options;
  options.weights = codegen::WeightType::kBfloat16;
  const codegen::FoldedModel folded = codegen::in_formats(codegen::fold(model), options);
  const Eigen::VectorXd latent = Eigen::VectorXd::Zero(model.nz()), found = Eigen::Vector2d::Ones();
  FlownMap map = flown_in_float(real, *folded.inverse_map());
  const Eigen::VectorXd bf16 = largest_at_draws<Arithmetic::kDeterministic>(model, vdp_bf16::kModel);
  EXPECT_GE((arithmetic_error(model, region, map, latent, found, 1, 0.1).bound - bf16).minCoeff(), 0.0);
  for (FlownLayer& layer : map.layers) layer.known.weights.setZero();
  EXPECT_LT((arithmetic_error(model, region, map, latent, found, 1, 0.1).bound - bf16).maxCoeff(), 0.0);
}

TEST(FlownArithmetic, LatentErrorBoundsLongFlights) {
  // A constant reading: z comes to rest early, because increments below half a unit in the last place are lost.
  const Model model = shipped_model();
  const Eigen::VectorXd bound = float_latent_error(model, model.latent_min, model.latent_max);
  codegen::ReferenceObserver<double> exact(model);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(model.nz());
  std::mt19937_64 engine(2);
  for (int run = 0; run < 200; ++run) {
    KklObserver<decltype(vdp_float::kModel), Arithmetic::kDeterministic> observer(vdp_float::kModel);
    exact.reset();
    const auto y = static_cast<float>(0.12 * (static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0));
    for (int k = 0; k < 3000; ++k) {
      (void)observer.step(y);
      exact.step(Eigen::VectorXd::Constant(1, static_cast<double>(y)));
      if (!codegen::LatentDomain(model).contains(exact.latent(), exact.output())) break;
      for (int i = 0; i < model.nz(); ++i)
        largest(i) = std::max(largest(i), std::abs(static_cast<double>(observer.latent()[i]) - exact.latent()(i)));
    }
  }
  for (Index i = 0; i < model.nz(); ++i) EXPECT_LE(largest(i), bound(i)) << "z" << i + 1;
  EXPECT_GT(largest.cwiseQuotient(bound).maxCoeff(), 0.02) << "control: a bound fifty times smaller is broken";
}

}  // namespace
}  // namespace nlo::trainer
