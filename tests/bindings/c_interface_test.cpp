// SPDX-License-Identifier: MIT
// The C interface for each structure: its results equal those of the observers, and it refuses wrong arguments.
#include "tests/bindings/pointers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "codegen/model/domain.h"
#include "codegen/model/latent_step.h"
#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/replay/replay_inputs.h"
#include "tests/codegen/example_models.h"

namespace nlo::codegen {
namespace {

constexpr int kStaleAfter = 10, kSamples = 120, kHalf = kSamples / 2;

/// A model behind the C interface, with difficult measurements: missing, out of range, late.
struct Tried {
  explicit Tried(const Model& m) : model(loaded(to_json(m))), inputs(replay_inputs(m, kStaleAfter, 3, kSamples)) {
    y = inputs.outputs.topRows(m.measured());
    dt_s = (inputs.dt_s.array() == 0.0).select(m.sample_period_s, inputs.dt_s);
    time_s.resize(kSamples);
    double now = 0.0;
    for (Eigen::Index k = 0; k < kSamples; ++k) time_s(k) = now += dt_s(k);
    for (Eigen::Index k = 1; k < kSamples; ++k) dt_s(k) = time_s(k) - time_s(k - 1);  // steps from the time stamps
    for (Eigen::Index k = 0; k < kSamples; ++k)
      if (std::abs(dt_s(k) - m.sample_period_s) < 1e-8 * m.sample_period_s) dt_s(k) = m.sample_period_s;
  }

  int step(nlo_observer* observer, Eigen::Index k) const {
    return nlo_observer_step_dt(observer, y.col(k).data(), u(k), dt_s(k));
  }
  const double* u(Eigen::Index k) const { return inputs.inputs.rows() == 0 ? nullptr : inputs.inputs.col(k).data(); }

  ModelPointer model;
  ReplayInputs inputs;
  Eigen::MatrixXd y;
  Eigen::VectorXd dt_s, time_s;
};

Eigen::VectorXd state_of(const nlo_observer* observer) {
  Eigen::VectorXd state(nlo_observer_state_size(observer));
  EXPECT_EQ(nlo_observer_save(observer, state.data()), NLO_DONE);
  return state;
}

template <class Scalar>
void expect_same_bits(const Model& m, const Tried& tried, int precision) {
  ReferenceObserver<Scalar> reference(m);
  const ObserverPointer observer(nlo_observer_create(tried.model.get(), precision));
  ASSERT_NE(observer, nullptr) << nlo_last_error();
  Eigen::VectorXd x_hat(m.nx()), sigma(m.nx()), z(m.nz());
  for (Eigen::Index k = 0; k < kSamples; ++k) {
    reference.step(tried.inputs.outputs.col(k), tried.inputs.inputs.col(k), tried.dt_s(k));
    ASSERT_EQ(tried.step(observer.get(), k), static_cast<int>(reference.status())) << "sample " << k;
    ASSERT_EQ(nlo_observer_estimate(observer.get(), x_hat.data()), NLO_DONE);
    ASSERT_EQ(nlo_observer_latent(observer.get(), z.data()), NLO_DONE);
    ASSERT_EQ(x_hat, reference.estimate().template cast<double>()) << "sample " << k;
    ASSERT_EQ(z, reference.latent().template cast<double>()) << "sample " << k;
    ASSERT_EQ(nlo_observer_in_domain(observer.get()), reference.in_domain() ? 1 : 0);
    const int known = nlo_observer_estimate_with_error(observer.get(), x_hat.data(), sigma.data());
    ASSERT_EQ(known, m.error ? NLO_DONE : NLO_NOT_KNOWN);
    if (!m.error) continue;
    ASSERT_EQ(sigma, reference.deviations(z, reference.output(), {reference.error_is_known()}).col(0));
  }
}

TEST(CInterface, StepsEveryStructureWithTheBitsOfItsObserver) {
  for (const Model& m : example_models()) {
    SCOPED_TRACE(m.name);
    const Tried tried(m);
    ASSERT_NE(tried.model, nullptr) << nlo_last_error();
    expect_same_bits<float>(m, tried, NLO_FLOAT);
    expect_same_bits<double>(m, tried, NLO_DOUBLE);
  }
}

TEST(CInterface, ARunEqualsItsStepsForEveryStructure) {
  constexpr double kRounding = 1e-10;  // matrix products sum in another order: 1e-16 of sums up to about 1e3
  for (const Model& m : example_models()) {
    SCOPED_TRACE(m.name);
    const Tried tried(m);
    Eigen::MatrixXd x_hat(m.nx(), kSamples), sigma(m.nx(), kSamples), z(m.nz(), kSamples);
    std::vector<std::int32_t> status(kSamples);
    std::vector<std::uint8_t> in_domain(kSamples);
    ASSERT_EQ(nlo_model_run(tried.model.get(), NLO_DOUBLE, kSamples, tried.y.data(), tried.u(0), tried.time_s.data(),
                            x_hat.data(), m.error ? sigma.data() : nullptr, z.data(), status.data(), in_domain.data()),
              NLO_DONE)
        << nlo_last_error();
    const ObserverPointer observer(nlo_observer_create(tried.model.get(), NLO_DOUBLE));
    Eigen::VectorXd now(m.nx()), latent(m.nz()), deviation(m.nx());
    for (Eigen::Index k = 0; k < kSamples; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const int said =
          k == 0 ? nlo_observer_step(observer.get(), tried.y.col(k).data(), tried.u(k)) : tried.step(observer.get(), k);
      ASSERT_EQ(said, status[at]) << "sample " << k;
      nlo_observer_estimate(observer.get(), now.data());
      nlo_observer_latent(observer.get(), latent.data());
      ASSERT_EQ(latent, z.col(k)) << "sample " << k;
      ASSERT_LT((now - x_hat.col(k)).cwiseAbs().maxCoeff(), kRounding * (1.0 + now.cwiseAbs().maxCoeff()));
      ASSERT_EQ(nlo_observer_in_domain(observer.get()), in_domain[at]);
      if (!m.error) continue;
      nlo_observer_estimate_with_error(observer.get(), now.data(), deviation.data());
      ASSERT_LT((deviation - sigma.col(k)).cwiseAbs().maxCoeff(), kRounding * (1.0 + deviation.maxCoeff()));
    }
    ASSERT_EQ(nlo_model_run(tried.model.get(), NLO_DOUBLE, 0, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
                            nullptr, nullptr),
              NLO_DONE);
  }
}

TEST(CInterface, CopiesAndRestoredObserversContinueWithTheSameBits) {
  for (const Model& m : example_models()) {
    SCOPED_TRACE(m.name);
    const Tried tried(m);
    const ObserverPointer observer(nlo_observer_create(tried.model.get(), NLO_FLOAT));
    const ObserverPointer restored(nlo_observer_create(tried.model.get(), NLO_FLOAT));
    const Eigen::VectorXd fresh = state_of(observer.get());
    for (Eigen::Index k = 0; k < kHalf; ++k) tried.step(observer.get(), k);
    const Eigen::VectorXd saved = state_of(observer.get());
    const ObserverPointer copy(nlo_observer_copy(observer.get()));
    ASSERT_EQ(nlo_observer_restore(restored.get(), saved.data(), static_cast<std::size_t>(saved.size())), NLO_DONE);
    ASSERT_EQ(nlo_observer_status(copy.get()), nlo_observer_status(observer.get()));
    for (Eigen::Index k = kHalf; k < kSamples; ++k)
      for (nlo_observer* each : {observer.get(), copy.get(), restored.get()}) tried.step(each, k);
    const Eigen::VectorXd end = state_of(observer.get());
    EXPECT_EQ(state_of(copy.get()), end);
    EXPECT_EQ(state_of(restored.get()), end);
    EXPECT_NE(end, saved) << "control: steps change the state";
    ASSERT_EQ(nlo_observer_reset(observer.get()), NLO_DONE);
    EXPECT_EQ(state_of(observer.get()), fresh);
  }
}

TEST(CInterface, RefusesACorruptedStateWithoutChangingAnything) {
  for (const Model& m : structure_models()) {
    SCOPED_TRACE(m.name);
    const Tried tried(m);
    const ObserverPointer observer(nlo_observer_create(tried.model.get(), NLO_FLOAT));
    for (Eigen::Index k = 0; k < kHalf; ++k) tried.step(observer.get(), k);
    const Eigen::VectorXd saved = state_of(observer.get());
    const auto size = static_cast<std::size_t>(saved.size());
    EXPECT_EQ(nlo_observer_restore(observer.get(), saved.data(), size - 1), NLO_BAD_ARGUMENT);
    for (Eigen::Index at = 0; at < saved.size(); ++at) {
      Eigen::VectorXd wrong = saved;
      wrong(at) = std::numeric_limits<double>::quiet_NaN();
      ASSERT_EQ(nlo_observer_restore(observer.get(), wrong.data(), size), NLO_BAD_ARGUMENT) << at;
      EXPECT_NE(std::string(nlo_last_error()), "");
    }
    EXPECT_EQ(state_of(observer.get()), saved);
  }
}

TEST(CInterface, SizesNamesAndUnitsAreThoseOfTheModel) {
  for (const Model& m : example_models()) {
    SCOPED_TRACE(m.name);
    const ModelPointer model = loaded(to_json(m));
    EXPECT_EQ(nlo_model_name(model.get()), m.name);
    EXPECT_EQ(nlo_model_structure(model.get()), structure_name(m));
    EXPECT_EQ(nlo_model_ny(model.get()), m.measured());
    EXPECT_EQ(nlo_model_nu(model.get()), m.nu());
    EXPECT_EQ(nlo_model_nx(model.get()), m.nx());
    EXPECT_EQ(nlo_model_nz(model.get()), m.nz());
    EXPECT_EQ(nlo_model_nr(model.get()), m.nr());
    EXPECT_EQ(nlo_model_sample_period_s(model.get()), m.sample_period_s);
    EXPECT_EQ(nlo_model_has_sigma(model.get()), m.error ? 1 : 0);
    EXPECT_EQ(nlo_model_json(model.get()), to_json(m));
    for (int i = 0; i < m.nx(); ++i) {
      const Channel& state = m.states[static_cast<std::size_t>(i)];
      EXPECT_EQ(nlo_model_channel_name(model.get(), NLO_STATE, i), state.name);
      EXPECT_EQ(nlo_model_channel_unit(model.get(), NLO_STATE, i), state.unit);
    }
    double low = 0.0, high = 0.0;
    for (int j = 0; j < m.measured(); ++j) {
      EXPECT_EQ(nlo_model_channel_turn(model.get(), NLO_OUTPUT, j), m.outputs[static_cast<std::size_t>(j)].wrap);
      EXPECT_EQ(nlo_model_channel_range(model.get(), NLO_OUTPUT, j, &low, &high), NLO_DONE);
      EXPECT_EQ(low, m.output_min(j));
      EXPECT_EQ(high, m.output_max(j));
    }
    EXPECT_EQ(nlo_model_channel_range(model.get(), NLO_OUTPUT, m.measured(), &low, &high), NLO_BAD_ARGUMENT);
    EXPECT_STREQ(nlo_model_channel_name(model.get(), 17, 0), "");
  }
}

TEST(CInterface, LatentSystemAndInverseMapAreThoseOfTheModel) {
  for (const Model& m : example_models()) {
    SCOPED_TRACE(m.name);
    const ModelPointer model = loaded(to_json(m));
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> d(m.nz(), m.nz()), f(m.nz(), m.nr());
    const int known = nlo_model_linear_latent(model.get(), d.data(), f.data());
    ASSERT_EQ(known, linear_latent(m) != nullptr ? NLO_DONE : NLO_NOT_KNOWN);
    if (known == NLO_DONE) {
      EXPECT_EQ(d, block_diagonal(m, linear_latent(m)->eigenvalues));
      EXPECT_EQ(f, linear_latent(m)->output_injection);
    }
    const Eigen::MatrixXd z = m.latent_min.replicate(1, 3), y = Eigen::MatrixXd::Constant(m.nr(), 3, 0.1);
    Eigen::MatrixXd x_hat(m.nx(), 3);
    ASSERT_EQ(nlo_model_inverse_map(model.get(), NLO_DOUBLE, 3, z.data(), y.data(), x_hat.data()), NLO_DONE);
    EXPECT_EQ(x_hat, ReferenceObserver<double>(m).estimates(z, y));
  }
}

}  // namespace
}  // namespace nlo::codegen
