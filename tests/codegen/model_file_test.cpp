// SPDX-License-Identifier: MIT
#include "codegen/model_file/model_file.h"
#include "codegen/structures/structure_module.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model_file/validate.h"
#include "tests/codegen/example_models.h"
#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

TEST(ModelFile, RoundTripGivesTheSameBytes) {
  for (const Model& m : example_models()) {
    const std::string json = to_json(m);
    EXPECT_EQ(to_json(parse_model(json, "text")), json) << m.name;
  }
}

TEST(ModelFile, RecordedActivationsReadBackAndAreOptional) {
  Model m = activation_model("relu");
  EXPECT_THAT(to_json(m), testing::Not(testing::HasSubstr("largest_activations")));
  inverse_map(m)->largest_activations = {3.5, 0.1};
  const Model again = parse_model(to_json(m), "text");
  EXPECT_EQ(inverse_map(again)->largest_activations, inverse_map(m)->largest_activations);
  for (const std::vector<double>& wrong : {std::vector{1.0}, std::vector{1.0, -1.0}}) {
    inverse_map(m)->largest_activations = wrong;
    EXPECT_THROW(validate(m), Error);
  }
}

TEST(ModelFile, EveryStructureIsNamedAndReadsBack) {
  std::set<std::string> seen;
  for (const Model& m : structure_models()) {
    const std::string name(structure_name(m));
    EXPECT_TRUE(seen.insert(name).second);
    const std::string json = to_json(m);
    EXPECT_THAT(json, testing::HasSubstr("\"structure\": \"" + name + "\""));
    const Model read = parse_model(json, "text");
    EXPECT_EQ(structure_name(read), name);
    EXPECT_EQ(to_json(read), json) << name;
  }
  EXPECT_EQ(seen.size() + 1, structure_modules().size()) << "kkl has its own models";
}

TEST(ModelFile, CommittedModelsHaveTheCurrentFormat) {
  for (const auto& file : std::filesystem::directory_iterator(NLO_SOURCE_DIR "/examples/models")) {
    if (file.path().extension() != ".json") continue;
    const std::string path = file.path().string();
    EXPECT_TRUE(to_json(read_model(path)) == read_file(path)) << path;
  }
}

TEST(ModelFile, Version1IsReadAndWrittenInTheCurrentFormat) {
  // A file of version 1, in which the networks were fields of the model and KKL was the only structure.
  const Model old = read_model(NLO_SOURCE_DIR "/tests/golden/model_version_1.json");
  EXPECT_EQ(structure_name(old), "kkl");
  EXPECT_EQ(old.nz(), 6);
  EXPECT_EQ(inverse_map(old)->feature_scale(0), 1.4289392232894897);
  EXPECT_EQ(inverse_map(old)->layers.size(), 3U);
  EXPECT_EQ(inverse_map(old)->outputs(), 2);
  const std::string json = to_json(old);
  EXPECT_NE(json.find("\"version\": 2"), std::string::npos);
  EXPECT_EQ(to_json(parse_model(json, "upgraded")), json);
}

TEST(ModelFile, RoundTripKeepsEveryBit) {
  Model m = rig_model();
  inverse_map(m)->layers[0].weights(0, 0) = std::numeric_limits<double>::denorm_min();
  inverse_map(m)->layers[0].weights(0, 1) = -0.0;
  inverse_map(m)->layers[0].weights(0, 2) = std::nextafter(1.0, 2.0);
  inverse_map(m)->layers[0].weights(0, 3) = std::nextafter(1e25, 0.0);  // sums up to 1e30 are valid
  const Model read = parse_model(to_json(m), "text");
  EXPECT_EQ(inverse_map(read)->layers[0].weights, inverse_map(m)->layers[0].weights);
  EXPECT_TRUE(std::signbit(inverse_map(read)->layers[0].weights(0, 1)));
  EXPECT_EQ(linear_latent(read)->eigenvalues, linear_latent(m)->eigenvalues);
  EXPECT_EQ(inverse_map(read)->features, inverse_map(m)->features);
  EXPECT_EQ(inverse_map(read)->skip, inverse_map(m)->skip);
  EXPECT_EQ(read.provenance, m.provenance);
  EXPECT_EQ(read.outputs[0].wrap, m.outputs[0].wrap);
}

TEST(ModelFile, TextsWithQuotesAndLineBreaksReadBack) {
  Model m = tiny_model();
  m.provenance = {{"config", "a = \"b\"\n\\ \t \xc3\xa9"}, {"zeta", "1"}, {"alpha", "2"}};
  EXPECT_EQ(parse_model(to_json(m), "text").provenance, m.provenance);
}

TEST(ModelFile, IsWrittenOnlyIfItCanBeReadAgain) {
  const ScratchDirectory scratch;
  const std::string path = scratch.path("model.json");
  Model m = tiny_model();
  write_model(m, path);
  EXPECT_EQ(to_json(read_model(path)), to_json(m));
  inverse_map(m)->layers[1].weights(0, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(thrown_message([&] { write_model(m, path); }),
              testing::HasSubstr("layers[1].weights[0][2] is not finite"));
  EXPECT_EQ(to_json(read_model(path)), to_json(tiny_model()));
}

}  // namespace
}  // namespace nlo::codegen
