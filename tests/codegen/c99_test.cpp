// SPDX-License-Identifier: MIT
// The texts of C99 exports; compile_c99.sh compiles and runs them.
#include "codegen/targets/c99.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/structures/module.h"
#include "codegen/targets/replay.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/golden.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string error_of(const Model& model, const ExportOptions& options = {}) {
  return thrown_message([&] { c99(PreparedExport(model, options)); });
}

TEST(C99, IsTheCommittedOne) {
  for (const NamedText& file : c99(PreparedExport(tiny_model(), {.name = "tiny_c99"})))
    expect_golden(file.text, file.path);
}

TEST(C99, RefusesOtherStructuresAndNamesTheMend) {
  for (const Model& model : structure_models()) {
    if (module_of(model).abilities().c99) continue;
    EXPECT_THAT(error_of(model), testing::AllOf(HasSubstr("target c99 writes kkl, gated"), HasSubstr("--target cpp")));
    EXPECT_THROW(replay_c99(PreparedExport(model, {})), Error);
  }
}

TEST(C99, StartsFromASteadyStateOnlyWhereThereIsOne) {
  for (const NamedText& file : c99(PreparedExport(gated_model(), {}))) EXPECT_THAT(file.text, Not(HasSubstr("steady")));
  for (const NamedText& file : c99(PreparedExport(rig_model(), {})))
    EXPECT_THAT(file.text, HasSubstr("rig_status rig_warm_start(rig_observer* observer"));
}

TEST(C99, RefusesWhatFloatCannotHoldAndModelsThatAreNotValid) {
  Model m = tiny_model();
  m.latent_max(1) = 1e39;
  EXPECT_THAT(error_of(m), testing::AllOf(HasSubstr("latent_max[1]"), HasSubstr("1e+39")));
  m = tiny_model();
  linear_latent(m)->eigenvalues(1) = 0.5;
  EXPECT_THAT(error_of(m), HasSubstr("must be negative"));
}

TEST(C99, WritesInt16AndRefusesWhatItCannotHold) {
  const auto files = c99(PreparedExport(rig_model(), {.name = "", .scalar = ScalarType::kInt16}));
  EXPECT_THAT(files[0].text, testing::AllOf(HasSubstr("--scalar int16"), HasSubstr("alpha_dot [rad/s]")));
  EXPECT_THAT(files[1].text,
              testing::AllOf(HasSubstr("static const IN_FLASH int16_t kWeights3"), HasSubstr("kTanhTable")));
  EXPECT_THAT(error_of(activation_model("silu"), {.name = "", .scalar = ScalarType::kInt16}), HasSubstr("silu"));
  const auto relu = c99(PreparedExport(activation_model("relu"), {.name = "", .scalar = ScalarType::kInt16}));
  EXPECT_THAT(relu[1].text, Not(HasSubstr("kTanhTable")));
}

TEST(C99, UserTextCanNeitherEndNorContinueAComment) {
  Model m = tiny_model();
  m.outputs[0].unit = "m\n#error unit\\";
  m.provenance = {{"a\n#error key", "*/ #error"}, {"escape", "ends with \\"}, {"return", "a\r#error"}};
  for (const NamedText& file : c99(PreparedExport(m, {}))) {
    EXPECT_THAT(file.text, Not(HasSubstr("\n#error u")));
    EXPECT_THAT(file.text, Not(HasSubstr("\\\n")));
    EXPECT_THAT(file.text, Not(HasSubstr("\r")));
    EXPECT_THAT(file.text, Not(HasSubstr("@"))) << "a key was left unfilled";
  }
}

TEST(C99, BothFilesOfAnExportNameTheSameOneAndNoOther) {
  const auto key = [](const std::string& text) { return text.substr(text.find("0x"), 10); };
  const auto files = c99(PreparedExport(tiny_model(), {}));
  EXPECT_THAT(files[1].text, HasSubstr("tiny_EXPORT != " + key(files[0].text)));
  Model other = tiny_model();
  inverse_map(other)->layers[1].bias(0) += 1e-6;
  EXPECT_NE(key(c99(PreparedExport(other, {}))[0].text), key(files[0].text));
}

TEST(EmbeddedText, KeepsTheLinesOfSectionsThatAValueAsksFor) {
  const std::string text = "a\n@if X@\nx\n@if Y@\nxy\n@end@\n@else@\nno x\n@if Y@\ny\n@end@\n@end@\nb";
  EXPECT_EQ(filled(text, {{"X", "1"}, {"Y", ""}}), "a\nx\nb");
  EXPECT_EQ(filled(text, {{"X", ""}, {"Y", "1"}}), "a\nno x\ny\nb");
  EXPECT_THROW(filled(text, {{"X", ""}}), std::logic_error);
  EXPECT_THROW(filled("@if X@\n", {{"X", ""}}), std::logic_error);
  EXPECT_THROW(filled("@end@\n", {}), std::logic_error);
}

TEST(EmbeddedText, FillsKeysAndLeavesOtherAtSigns) {
  EXPECT_EQ(filled("a @KEY@ b@c @ @@ @key@", {{"KEY", "x@Y@"}}), "a x@Y@ b@c @ @@ @key@");
  EXPECT_THROW(filled("@OTHER@", {}), std::logic_error);
  EXPECT_THROW(embedded_text("none"), std::logic_error);
}

}  // namespace
}  // namespace nlo::codegen
