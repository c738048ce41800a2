// SPDX-License-Identifier: MIT
// Model files that are broken, malicious or of another version, and the message that each must give. Each row edits the
// text of a valid model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

struct Row {
  const char* what;
  const char* find;     ///< its first occurrence in the file...
  std::string replace;  ///< ...becomes this
  const char* message;  ///< part of the expected message
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
  return out << row.what;
}

std::string message_of(const std::string& json) {
  return thrown_message([&] { parse_model(json, "m.json"); });
}

std::string edited(std::string json, const std::string& find, const std::string& replace) {
  const auto at = json.find(find);
  EXPECT_NE(at, std::string::npos) << "the table looks for \"" << find << "\", which the file does not have";
  if (at != std::string::npos) json.replace(at, find.size(), replace);
  return json;
}

class HostileModel : public testing::TestWithParam<Row> {};

TEST_P(HostileModel, IsRefusedWithTheFileTheFieldAndTheRemedy) {
  const Row& row = GetParam();
  const std::string message = message_of(edited(to_json(rig_model()), row.find, row.replace));
  EXPECT_THAT(message, testing::HasSubstr(row.message));
  EXPECT_EQ(message.rfind("m.json:", 0), 0U) << message;
}

const Row kRows[] = {
    {"VersionTooLow", "\"version\": 2", "\"version\": 1", "structure: is not a field of version 1"},
    {"VersionZero", "\"version\": 2", "\"version\": 0", "version: is 0; this nlo reads versions 1 to 2"},
    {"NewerVersion", "\"version\": 2", "\"version\": 3",
     "version: is 3; this nlo reads versions 1 to 2: a newer nlo wrote the file, update this one"},
    {"MuchNewerVersion", "\"version\": 2", "\"version\": 18446744073709551615", "a newer nlo wrote the file"},
    {"VersionFraction", "\"version\": 2", "\"version\": 2.5", "version: is not a whole number"},
    {"VersionAsText", "\"version\": 2", "\"version\": \"2\"", "version: is not a whole number"},
    {"VersionMissing", "\"version\": 2,", "", "version: is missing"},
    {"OtherFormat", "nlo-model", "onnx", "is JSON but no nlo model"},
    {"FormatMissing", "\"format\": \"nlo-model\",", "", "is JSON but no nlo model"},
    {"StructureMissing", "\"structure\": \"kkl\",", "", "structure: is missing"},
    {"StructureUnknown", "\"structure\": \"kkl\"", "\"structure\": \"kalman\"",
     "structure: is unknown; there are kkl, driven_kkl, luenberger, general"},
    {"StructureOther", "\"structure\": \"kkl\"", "\"structure\": \"general\"", "\"starts_steady\": unknown field"},
    {"DriveMissing", "\"structure\": \"kkl\"", "\"structure\": \"driven_kkl\"", "drive: is missing"},
    {"FieldMissing", "\"hold\": \"first_order\",", "", "hold: is missing"},
    {"FieldUnknown", "\"hold\"", "\"holt\": 1, \"hold\"", "\"holt\": unknown field"},
    {"FieldTwice", "\"hold\"", "\"pairs\": 2, \"hold\"", "\"pairs\": is given twice"},
    {"ChannelFieldUnknown", "\"unit\"", "\"units\": \"\", \"unit\"", "outputs[0].\"units\": unknown field"},
    {"NumberAsText", "\"sample_period_s\": 0.004", "\"sample_period_s\": \"4ms\"", "sample_period_s: is a JSON string"},
    {"NullNumber", "\"sample_period_s\": 0.004", "\"sample_period_s\": null", "sample_period_s: is null"},
    {"NumberTooLarge", "\"sample_period_s\": 0.004", "\"sample_period_s\": 1e999", "beyond the range of double"},
    {"NaN", "\"sample_period_s\": 0.004", "\"sample_period_s\": NaN", "is not JSON"},
    {"PeriodZero", "\"sample_period_s\": 0.004", "\"sample_period_s\": 0", "sample_period_s is 0; it must be positive"},
    {"PeriodNegative", "\"sample_period_s\": 0.004", "\"sample_period_s\": -1", "sample_period_s is -1"},
    {"PeriodHuge", "\"sample_period_s\": 0.004", "\"sample_period_s\": 1e20", "exceeds 1000 per sample"},
    {"HoldUnknown", "first_order", "second_order", "hold is unknown; use zero_order, first_order or rk4"},
    {"ActivationUnknown", "\"tanh\"", "\"sigmoid\"", "activation is unknown; use tanh, relu"},
    {"PairsNegative", "\"pairs\": 2", "\"pairs\": -1", "pairs: is -1; expected 0 to"},
    {"PairsFraction", "\"pairs\": 2", "\"pairs\": 1.5", "pairs: is a JSON number; expected an integer"},
    {"PairsTooMany", "\"pairs\": 2", "\"pairs\": 4", "pairs is 4; with 7 latent states it must be 0 to 3"},
    {"NotHurwitz", "[-40.0, 30.0", "[40.0, 30.0", "eigenvalues[0] is 40; its real part must be negative"},
    {"RealPartZero", "-25.0, 35.0", "0.0, 35.0", "eigenvalues[2] is 0; its real part must be negative"},
    {"ClockGrows", "-15.0, -2.0]", "-15.0, 2.0]", "eigenvalues[6] is 2; its real part must be negative"},
    {"TooSlow", "-15.0, -2.0]", "-15.0, -1e-9]", "so slow that float cannot distinguish it from an integrator"},
    {"EigenvaluesEmpty", "[-40.0, 30.0, -25.0, 35.0, -60.0, -15.0, -2.0]", "[]",
     "eigenvalues has 0 entries; it must have 7 (n_z, the size of initial_latent)"},
    {"EigenvalueMissing", "-15.0, -2.0]", "-15.0]", "eigenvalues has 6 entries; it must have 7"},
    {"RaggedMatrix", "[40.0, 0.0]", "[40.0]", "output_injection[1]: has 2 numbers and the rows above have 1"},
    {"MatrixOfTexts", "[40.0, 0.0]", "[\"40\", 0.0]", "output_injection[0][0]: is a JSON string; expected a number"},
    {"VectorForMatrix", "\"skip\": [", "\"skip\": [1, ", "inverse_map.skip[0]: is a JSON number; expected an array"},
    {"StartsSteadyAsNumber", "\"starts_steady\": true", "\"starts_steady\": 1", "starts_steady: is a JSON number"},
    {"RangeReversed", "\"output_min\": [-3.141592653589793, -5.0]", "\"output_min\": [-3.1, 6]",
     "output_min[1] is 6 and output_max[1] is 5; the minimum must be smaller"},
    {"ScaleZero", "\"output_scale\": [8.0", "\"output_scale\": [0.0",
     "inverse_map.output_scale[0] is 0; a scale must be positive"},
    {"ScaleNegative", "\"feature_scale\": [0.2", "\"feature_scale\": [-0.2", "feature_scale[0] is -0.2"},
    {"WrapNegative", "\"wrap\": 0.0", "\"wrap\": -1", "outputs[1].wrap is -1"},
    {"NameIsKeyword", "\"name\": \"rig\"", "\"name\": \"namespace\"", "name is not an identifier"},
    {"NameIsPath", "\"name\": \"rig\"", "\"name\": \"../../etc/passwd\"", "name is not an identifier"},
    {"NameIsCode", "\"name\": \"alpha\"", "\"name\": \"a;system(0)\"", "outputs[0].name is not an identifier"},
    {"NameTooLong", "\"name\": \"rig\"", "\"name\": \"" + std::string(64, 'x') + "\"", "name is not an identifier"},
    {"NameTwice", "\"load_dot\"", "\"alpha_dot\"", "states[0].name and states[1].name are both \"alpha_dot\""},
    {"OutputsEmpty", "\"states\": [", "\"states\": [], \"x\": [", "\"x\": unknown field"},
    {"LayersEmpty", "\"layers\": [", "\"layers\": [], \"layer\": [", "inverse_map.\"layer\": unknown field"},
    {"AngleReadRaw", "[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0]", "[1.0, 0, 0, 0, 0, 0, 0, 0.0, 0.0]",
     "inverse_map.features[0] changes by 1 per unit of the angle outputs[0] (\"alpha\")"},
    {"ProvenanceNumber", "\"seed\": \"2\"", "\"seed\": 2", "provenance.seed: is a JSON number; expected a text"},
    {"ProvenanceTwice", "\"seed\": \"2\"", "\"seed\": \"2\", \"seed\": \"3\"", "\"seed\": is given twice"},
    {"NotUtf8", "\"plant\"", "\"pl\xff\"", "is not JSON"},
    {"TrailingText", "\"format\"", "} \"format\"", "is not JSON"},
    {"Comment", "\"format\"", "// \"format\"", "is not JSON"},
};

INSTANTIATE_TEST_SUITE_P(Table, HostileModel, testing::ValuesIn(kRows),
                         [](const auto& row) { return std::string(row.param.what); });

TEST(HostileModelFile, RefusesEveryTruncation) {
  std::vector<Model> models = structure_models();
  models.push_back(tiny_model());
  const std::string json = to_json(tiny_model());
  for (const Model& model : models) {
    const std::string whole = to_json(model);
    const std::size_t stride = whole.size() / 1000 + 1;  // for a long file, a thousand truncations
    for (std::size_t size = 0; size + 2 < whole.size(); size += stride) {
      const std::string message = message_of(whole.substr(0, size));
      ASSERT_THAT(message, testing::HasSubstr(size == 0 ? "the file is empty" : "m.json:")) << model.name << size;
      ASSERT_NE(message, "no error") << model.name << size;
    }
  }
  EXPECT_THAT(message_of(json.substr(0, json.size() / 2)), testing::HasSubstr("it was cut off"));
}

TEST(HostileModelFile, ChecksNamesAndTypesOfTheFieldsOfEachStructure) {
  const std::string luenberger = to_json(luenberger_model()), general = to_json(general_model()),
                    driven = to_json(driven_model());
  const auto refusal = [](const std::string& json, const std::string& find, const std::string& replace) {
    return message_of(edited(json, find, replace));
  };
  EXPECT_THAT(refusal(luenberger, "\"gain\"", "\"Gain\""), testing::HasSubstr("luenberger.\"Gain\": unknown field"));
  EXPECT_THAT(refusal(luenberger, "\"state_matrix\": [", "\"state_matrix\": [1, "),
              testing::HasSubstr("luenberger.state_matrix[0]: is a JSON number"));
  EXPECT_THAT(refusal(luenberger, "\"luenberger\": {", "\"luenberger\": 1, \"x\": {"),
              testing::HasSubstr("\"x\": unknown field"));
  EXPECT_THAT(refusal(luenberger, "\"luenberger\": {", "\"eigenvalues\": [-1], \"luenberger\": {"),
              testing::HasSubstr("\"eigenvalues\": unknown field"));
  EXPECT_THAT(refusal(general, "\"dynamics\"", "\"inverse_map\""),
              testing::HasSubstr("\"inverse_map\": is given twice"));
  EXPECT_THAT(refusal(general, "\"structure\": \"general\"", "\"structure\": 4"),
              testing::HasSubstr("structure: is a JSON number; expected a text"));
  EXPECT_THAT(refusal(driven, "\"input_hold\": \"first_order\",", ""),
              testing::HasSubstr("drive.input_hold: is missing"));
  EXPECT_THAT(refusal(driven, "\"forward_map\": {", "\"forward_map\": {\"depth\": 3, "),
              testing::HasSubstr("drive.forward_map.\"depth\": unknown field"));
  EXPECT_THAT(refusal(driven, "\"inputs\": [", "\"inputs\": [1, "),
              testing::HasSubstr("drive.inputs[0]: is a JSON number"));
}

TEST(HostileModelFile, RefusesDeepNestingBeforeItOverflowsTheStack) {
  const std::string deep(1000000, '[');
  EXPECT_THAT(message_of(deep), testing::HasSubstr("nests deeper than"));
  EXPECT_THAT(message_of(edited(to_json(tiny_model()), "\"skip\": [", "\"skip\": " + deep)),
              testing::HasSubstr("nests deeper than"));
}

TEST(HostileModelFile, SyntaxErrorsNameLineAndColumn) {
  EXPECT_THAT(message_of("{\n  \"format\": nlo\n}"), testing::HasSubstr("m.json:2:14: is not JSON"));
  EXPECT_THAT(message_of("%PDF-1.4"), testing::HasSubstr("m.json:1:1: is not JSON"));
  EXPECT_THAT(message_of("[1, 2]"), testing::HasSubstr("is JSON but no nlo model"));
}

TEST(HostileModelFile, ErrorsOfShapesNameTheFieldAndBothShapes) {
  const auto message = [](const auto& corrupt) {
    Model m = rig_model();
    corrupt(m);
    return message_of(to_json(m));
  };
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->layers[1].weights.conservativeResize(24, 31); }),
              testing::HasSubstr("layers[1].weights is 24 x 31; it must be 24 x 32"));
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->layers[2].bias.conservativeResize(2); }),
              testing::HasSubstr("layers[2].bias has 2 entries; it must have 3"));
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->layers.pop_back(); }),
              testing::HasSubstr("layers[1].weights is 24 x 32; it must be 3 x 32"));
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->features.conservativeResize(8, 8); }),
              testing::HasSubstr("features is 8 x 8; it must be 8 x 9"));
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->layers.clear(); }), testing::HasSubstr("layers is empty"));
  EXPECT_THAT(message([](Model& m) { m.states.clear(); }), testing::HasSubstr("states is empty"));
  EXPECT_THAT(message([](Model& m) { inverse_map(m)->skip.conservativeResize(3, 2); }),
              testing::HasSubstr("skip is 3 x 2; it must be 3 x 8"));
}

}  // namespace
}  // namespace nlo::codegen
