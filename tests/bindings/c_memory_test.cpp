// SPDX-License-Identifier: MIT
// The installed libnlo-model.so: in a loop of steps, estimates and all other calls it allocates no memory from the
// system and takes no lock, for each structure, and gives the bits of the reference.
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/replay/replay_inputs.h"
#include "tests/bindings/pointers.h"
#include "tests/codegen/example_models.h"
#include "tests/properties/traps.h"

namespace nlo::codegen {
namespace {

using nlo::testing::Trap;

constexpr int kStaleAfter = 10, kSamples = 60;

/// A flight: its allocations and its results.
struct Flown {
  explicit Flown(const Model& m)
      : inputs(replay_inputs(m, kStaleAfter, 3, kSamples)),
        y(inputs.outputs.topRows(m.measured())),
        x_hat(m.nx(), kSamples),
        sigma(m.nx()),
        z(m.nz()) {}

  const double* u(Eigen::Index k) const { return inputs.inputs.rows() == 0 ? nullptr : inputs.inputs.col(k).data(); }

  /// Returns the number of allocations and locks of this thread from the first step on.
  int fly(const Model& m, nlo_observer* observer) {
    state.resize(nlo_observer_state_size(observer));
    Trap trap;
    for (Eigen::Index k = 0; k < kSamples; ++k) {
      const double dt_s = inputs.dt_s(k);
      failed += (dt_s > 0.0 ? nlo_observer_step_dt(observer, y.col(k).data(), u(k), dt_s)
                            : nlo_observer_step(observer, y.col(k).data(), u(k))) < 0;
      failed += nlo_observer_estimate(observer, x_hat.col(k).data()) != NLO_DONE;
      if (m.error) failed += nlo_observer_estimate_with_error(observer, x_hat.col(k).data(), sigma.data()) != NLO_DONE;
      failed += nlo_observer_in_domain(observer) < 0 || nlo_observer_status(observer) < 0;
      failed += nlo_observer_latent(observer, z.data()) != NLO_DONE;
      failed += nlo_observer_save(observer, state.data()) != NLO_DONE;
      failed += nlo_observer_restore(observer, state.data(), static_cast<std::size_t>(state.size())) != NLO_DONE;
      if (k == kSamples / 2) failed += nlo_observer_reset(observer) != NLO_DONE;
    }
    trap.disarm();
    return trap.allocations() + trap.locks();
  }

  ReplayInputs inputs;
  Eigen::MatrixXd y, x_hat;
  Eigen::VectorXd sigma, z, state;
  int failed = 0;
};

template <class Scalar>
void expect_reference_bits(const Model& m, const Flown& flown) {
  ReferenceObserver<Scalar> reference(m);
  for (Eigen::Index k = 0; k < kSamples; ++k) {
    const Eigen::VectorXd y = flown.inputs.outputs.col(k),
                          u = m.nu() == 0 ? Eigen::VectorXd() : Eigen::VectorXd(flown.inputs.inputs.col(k));
    if (flown.inputs.dt_s(k) > 0.0)
      reference.step(y, u, flown.inputs.dt_s(k));
    else
      reference.step(y, u);
    EXPECT_EQ(flown.x_hat.col(k), Eigen::VectorXd(reference.estimate().template cast<double>())) << m.name << " " << k;
    if (k == kSamples / 2) reference.reset();
  }
}

TEST(StepMemory, MakesALoopFreeOfAllocationsAndLocksForAnyStructure) {
  std::vector<Model> models = example_models();
  models.push_back(mixed_model());
  for (const Model& m : models)
    for (const int precision : {NLO_FLOAT, NLO_DOUBLE}) {
      const ModelPointer model = loaded(to_json(m));
      ASSERT_NE(model, nullptr) << nlo_last_error();
      const ObserverPointer observer(nlo_observer_create(model.get(), precision));
      ASSERT_NE(observer, nullptr) << nlo_last_error();
      Flown flown(m);
      EXPECT_EQ(flown.fly(m, observer.get()), 0) << m.name << " in " << precision;
      EXPECT_EQ(flown.failed, 0) << m.name << ": " << nlo_last_error();
      if (precision == NLO_FLOAT) expect_reference_bits<float>(m, flown);
      if (precision == NLO_DOUBLE) expect_reference_bits<double>(m, flown);
    }
}

TEST(StepMemory, BelongsToTheObserverAndNotToItsThread) {
  const Model m = rig_model();
  ModelPointer model = loaded(to_json(m));
  ObserverPointer first(nlo_observer_create(model.get(), NLO_FLOAT)), second(nlo_observer_copy(first.get()));
  model.reset();
  Flown one(m), other(m);
  int taken_by_one = -1, taken_by_other = -1;
  std::thread a([&] { taken_by_one = one.fly(m, first.get()); });
  a.join();
  std::thread b([&] {
    taken_by_other = other.fly(m, second.get());
    second.reset();
  });
  b.join();
  EXPECT_EQ(taken_by_one, 0);
  EXPECT_EQ(taken_by_other, 0);
  EXPECT_EQ(one.x_hat, other.x_hat);
  EXPECT_EQ(one.failed + other.failed, 0);
  const ObserverPointer third(nlo_observer_copy(first.get()));  // in the state after the flight
  first.reset();
  Eigen::VectorXd x_hat(m.nx());
  EXPECT_EQ(nlo_observer_estimate(third.get(), x_hat.data()), NLO_DONE);
  EXPECT_EQ(x_hat, one.x_hat.rightCols(1));
}

TEST(StepMemory, ARefusalInALoopHasNoOtherEffect) {
  const Model m = driven_model();
  const ModelPointer model = loaded(to_json(m));
  const ObserverPointer observer(nlo_observer_create(model.get(), NLO_FLOAT));
  EXPECT_STREQ(nlo_last_error(), "");  // no error at its creation
  Flown flown(m);
  double sigma = 0.0;
  for (int times = 0; times < 100; ++times) {
    EXPECT_EQ(nlo_observer_step(observer.get(), nullptr, nullptr), NLO_BAD_ARGUMENT);
    EXPECT_EQ(nlo_observer_estimate_with_error(observer.get(), flown.x_hat.data(), &sigma), NLO_NOT_KNOWN);
    EXPECT_EQ(nlo_observer_restore(observer.get(), &sigma, 1), NLO_BAD_ARGUMENT);
  }
  EXPECT_EQ(flown.fly(m, observer.get()), 0);
  expect_reference_bits<float>(m, flown);
}

/// Control: the test detects allocations of the library.
TEST(StepMemory, ControlTheTrapDetectsAllocationsOutsideOfALoop) {
  const Model m = tiny_model();
  const ModelPointer model = loaded(to_json(m));
  const double y[3] = {0.1, 0.2, 0.3};
  Eigen::MatrixXd x_hat(m.nx(), 3);
  Trap trap;
  nlo_model_run(model.get(), NLO_FLOAT, 3, y, nullptr, nullptr, x_hat.data(), nullptr, nullptr, nullptr, nullptr);
  trap.disarm();
  EXPECT_GT(trap.allocations(), 0);
}

}  // namespace
}  // namespace nlo::codegen
