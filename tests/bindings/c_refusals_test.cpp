// SPDX-License-Identifier: MIT
// The C interface with wrong arguments: it returns a code and a text, and never crashes.
#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "tests/bindings/pointers.h"
#include "tests/codegen/example_models.h"
#include "tests/support/scratch_directory.h"

namespace nlo::codegen {
namespace {

TEST(CInterfaceRefusals, RefusesTruncatedModels) {
  const std::string json = to_json(tiny_model());
  // The last two bytes are a brace and a newline.
  for (std::size_t size = 0; size + 2 < json.size(); ++size) {
    ASSERT_EQ(nlo_model_from_bytes(json.data(), size), nullptr) << size << " of " << json.size();
    ASSERT_NE(std::string(nlo_last_error()), "");
  }
}

TEST(CInterfaceRefusals, RefusesFlippedBitsOrLoadsAnotherValidModel) {
  const std::string json = to_json(tiny_model());
  int refused = 0, accepted = 0;
  for (std::size_t bit = 0; bit < 8 * json.size(); bit += 3) {
    std::string corrupted = json;
    corrupted[bit / 8] = static_cast<char>(corrupted[bit / 8] ^ (1 << (bit % 8)));
    const ModelPointer model = loaded(corrupted);
    if (model == nullptr) {
      ++refused;
      ASSERT_NE(std::string(nlo_last_error()), "") << "bit " << bit;
      continue;
    }
    ++accepted;
    const ObserverPointer observer(nlo_observer_create(model.get(), NLO_FLOAT));
    const std::vector<double> y(static_cast<std::size_t>(nlo_model_ny(model.get())), 0.5);
    std::vector<double> x_hat(static_cast<std::size_t>(nlo_model_nx(model.get())));
    for (int k = 0; k < 3; ++k) ASSERT_GE(nlo_observer_step(observer.get(), y.data(), nullptr), 0);
    ASSERT_EQ(nlo_observer_estimate(observer.get(), x_hat.data()), NLO_DONE);
  }
  EXPECT_GT(refused, accepted) << "a flip may change a digit, but no key or bracket";
  EXPECT_GT(accepted, 0) << "control: some flips change digits";
}

TEST(CInterfaceRefusals, ErrorsNameTheFileAndTheField) {
  std::string json = to_json(tiny_model());
  const std::string now = "\"version\": 2";
  json.replace(json.find(now), now.size(), "\"version\": 999");
  EXPECT_EQ(loaded(json), nullptr);
  EXPECT_STREQ(nlo_last_error(),
               "model: version: is 999; this nlo reads versions 1 to 2: a newer nlo wrote the file, update this one");
  const ScratchDirectory scratch;
  const std::string path = scratch.write("wrong.json", json);
  EXPECT_EQ(nlo_model_from_file(path.c_str()), nullptr);
  EXPECT_EQ(std::string(nlo_last_error()).rfind(path + ": version", 0), 0U) << nlo_last_error();
  EXPECT_EQ(nlo_model_from_file(scratch.path("none.json").c_str()), nullptr);
  EXPECT_NE(std::string(nlo_last_error()).find("none.json"), std::string::npos) << nlo_last_error();
  std::thread([] { EXPECT_STREQ(nlo_last_error(), "") << "each thread has its own error"; }).join();
}

TEST(CInterfaceRefusals, NullPointersAndWrongNumbersAreRefused) {
  const ModelPointer model = loaded(to_json(commanded_model()));
  const ObserverPointer observer(nlo_observer_create(model.get(), NLO_DOUBLE));
  const double y[8] = {};
  double out[64];
  EXPECT_EQ(nlo_observer_create(nullptr, NLO_FLOAT), nullptr);
  EXPECT_EQ(nlo_observer_create(model.get(), 16), nullptr);
  EXPECT_EQ(nlo_observer_copy(nullptr), nullptr);
  EXPECT_EQ(nlo_model_from_bytes(nullptr, 4), nullptr);
  EXPECT_EQ(nlo_model_from_file(nullptr), nullptr);
  EXPECT_EQ(nlo_observer_step(nullptr, y, y), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_observer_step(observer.get(), nullptr, y), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_observer_step(observer.get(), y, nullptr), NLO_BAD_ARGUMENT) << "u is missing";
  EXPECT_STREQ(nlo_last_error(), "u is NULL");
  EXPECT_EQ(nlo_observer_estimate(observer.get(), nullptr), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_observer_estimate(nullptr, out), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_observer_in_domain(nullptr), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_observer_save(observer.get(), nullptr), NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_model_run(model.get(), NLO_FLOAT, 2, nullptr, y, nullptr, out, nullptr, nullptr, nullptr, nullptr),
            NLO_BAD_ARGUMENT);
  EXPECT_EQ(nlo_model_ny(nullptr), 0);
  EXPECT_STREQ(nlo_model_name(nullptr), "");
  nlo_model_free(nullptr);
  nlo_observer_free(nullptr);
  for (const double dt_s : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(nlo_observer_step(observer.get(), y, y), NLO_OK);
    EXPECT_EQ(nlo_observer_step_dt(observer.get(), y, y, dt_s), NLO_REJECTED);
  }
}

TEST(CInterfaceRefusals, AnObserverOutlivesItsModel) {
  ModelPointer model = loaded(to_json(tiny_model()));
  const ObserverPointer observer(nlo_observer_create(model.get(), NLO_FLOAT));
  model.reset();
  const double y = 0.5;
  double x_hat = 0.0;
  EXPECT_EQ(nlo_observer_step(observer.get(), &y, nullptr), NLO_OK);
  EXPECT_EQ(nlo_observer_estimate(observer.get(), &x_hat), NLO_DONE);
}

}  // namespace
}  // namespace nlo::codegen
