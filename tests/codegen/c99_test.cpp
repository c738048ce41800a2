// SPDX-License-Identifier: MIT
// Texts of C99 exports, which compile_c99.sh compiles and runs, and of the folders for package managers, which
// compile_libraries.sh compiles.
#include "codegen/targets/c99.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/golden_replay.h"
#include "codegen/targets/library.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/golden.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::string error_of(const Model& model, const ExportOptions& options = {}) {
  return thrown_message([&] { c99(PreparedExport(model, options)); });
}

TEST(C99, EqualsItsGoldenFile) {
  for (const NamedText& file : c99(PreparedExport(tiny_model(), {.name = "tiny_c99"})))
    expect_golden(file.text, file.path);
}

TEST(C99, IsWrittenForEveryStructure) {
  for (const StructureModule* module : structure_modules()) EXPECT_TRUE(module->abilities().c99) << module->name();
}

TEST(C99, DefinesOnlyTheFunctionsThatItsEquationsCall) {
  std::string source;
  for (const NamedText& file : c99(PreparedExport(hidden_joint_model(), {}))) source += file.text;
  EXPECT_THAT(source, HasSubstr("static Circle circle("));
  EXPECT_THAT(source, HasSubstr("static Scalar hyperbolic_tangent("));
  for (const char* unused : {" sine(", " cosine(", " arc_tangent(", " exponential("})
    EXPECT_THAT(source, Not(HasSubstr(unused))) << "compilers warn about a static function without a call";
}

TEST(C99, StartsFromASteadyStateOnlyIfThereIsOne) {
  for (const NamedText& file : c99(PreparedExport(gated_model(), {}))) EXPECT_THAT(file.text, Not(HasSubstr("steady")));
  for (const NamedText& file : c99(PreparedExport(rig_model(), {})))
    EXPECT_THAT(file.text, HasSubstr("rig_status rig_warm_start(rig_observer* observer"));
}

TEST(C99, RefusesNumbersBeyondFloatAndInvalidModels) {
  Model m = tiny_model();
  m.latent_max(1) = 1e39;
  EXPECT_THAT(error_of(m), testing::AllOf(HasSubstr("latent_max[1]"), HasSubstr("1e+39")));
  m = tiny_model();
  linear_latent(m)->eigenvalues(1) = 0.5;
  EXPECT_THAT(error_of(m), HasSubstr("must be negative"));
}

TEST(C99, WritesInt16AndRefusesWeightsThatItCannotHold) {
  const auto files = c99(PreparedExport(rig_model(), {.name = "", .scalar = ScalarType::kInt16}));
  EXPECT_THAT(files[0].text, testing::AllOf(HasSubstr("--scalar int16"), HasSubstr("alpha_dot [rad/s]")));
  EXPECT_THAT(files[1].text,
              testing::AllOf(HasSubstr("static const IN_FLASH int16_t kWeights3"), HasSubstr("kTanhTable")));
  EXPECT_THAT(error_of(driven_model(), {.name = "", .scalar = ScalarType::kInt16}), HasSubstr("int16 exists only for"));
  const auto silu = c99(PreparedExport(activation_model("silu"), {.name = "", .scalar = ScalarType::kInt16}));
  EXPECT_THAT(silu[1].text, testing::AllOf(HasSubstr("values[o] = silu_q15("), HasSubstr("kTanhTable")));
  const auto relu = c99(PreparedExport(activation_model("relu"), {.name = "", .scalar = ScalarType::kInt16}));
  EXPECT_THAT(relu[1].text, Not(HasSubstr("kTanhTable")));
}

TEST(C99, UserTextCannotEndOrContinueAComment) {
  Model m = tiny_model();
  m.outputs[0].unit = "m\n#error unit\\";
  m.provenance = {{"a\n#error key", "*/ #error"}, {"escape", "ends with \\"}, {"return", "a\r#error"}};
  for (const NamedText& file : c99(PreparedExport(m, {}))) {
    EXPECT_THAT(file.text, Not(HasSubstr("\n#error u")));
    EXPECT_THAT(file.text, Not(HasSubstr("\\\n")));
    EXPECT_THAT(file.text, Not(HasSubstr("\r")));
    EXPECT_THAT(file.text, Not(HasSubstr("@"))) << "a key was not filled in";
  }
}

TEST(C99, BothFilesOfAnExportUseOnlyItsName) {
  const auto key = [](const std::string& text) { return text.substr(text.find("0x"), 10); };
  const auto files = c99(PreparedExport(tiny_model(), {}));
  EXPECT_THAT(files[1].text, HasSubstr("tiny_EXPORT != " + key(files[0].text)));
  Model other = tiny_model();
  inverse_map(other)->layers[1].bias(0) += 1e-6;
  EXPECT_NE(key(c99(PreparedExport(other, {}))[0].text), key(files[0].text));
}

TEST(EmbeddedText, KeepsTheLinesOfSectionsThatAreTurnedOn) {
  const std::string text = "a\n@if X@\nx\n@if Y@\nxy\n@end@\n@else@\nno x\n@if Y@\ny\n@end@\n@end@\nb";
  EXPECT_EQ(filled(text, {{"X", "1"}, {"Y", ""}}), "a\nx\nb");
  EXPECT_EQ(filled(text, {{"X", ""}, {"Y", "1"}}), "a\nno x\ny\nb");
  EXPECT_THROW(filled(text, {{"X", ""}}), std::logic_error);
  EXPECT_THROW(filled("@if X@\n", {{"X", ""}}), std::logic_error);
  EXPECT_THROW(filled("@end@\n", {}), std::logic_error);
}

TEST(EmbeddedText, FillsInKeysAndKeepsOtherAtSigns) {
  EXPECT_EQ(filled("a @KEY@ b@c @ @@ @key@", {{"KEY", "x@Y@"}}), "a x@Y@ b@c @ @@ @key@");
  EXPECT_THROW(filled("@OTHER@", {}), std::logic_error);
  EXPECT_THROW(embedded_text("none"), std::logic_error);
}

std::string text_of(const std::vector<NamedText>& files, const std::string& path) {
  for (const NamedText& file : files)
    if (file.path == path) return file.text;
  ADD_FAILURE() << "there is no " << path;
  return "";
}

TEST(Library, ContainsTheRuntimeHeadersThatItIncludesAndNoEigen) {
  const auto kkl = runtime_headers("#include <nlo/kkl_observer.h>");
  EXPECT_THAT(kkl, testing::IsSupersetOf({"nlo/kkl_observer.h", "nlo/vector.h", "nlo/kernels/per_isa/vectors.inc"}));
  EXPECT_THAT(kkl, Not(testing::AnyOf(Contains("nlo/eigen.h"), Contains("nlo/driven_kkl_observer.h"))));
  EXPECT_THAT(runtime_headers("#include <nlo/driven_kkl_observer.h>"), Contains("nlo/exponential_rk.h"));
  EXPECT_TRUE(runtime_headers("#include <string>").empty());
  EXPECT_THROW(runtime_headers("#include <nlo/none.h>"), std::logic_error) << "a header that is missing is seen here";
  const auto files = arduino_library(PreparedExport(tiny_model(), {}));
  EXPECT_EQ(text_of(files, "src/nlo/vector.h"), read_file(NLO_SOURCE_DIR "/runtime/include/nlo/vector.h"));
}

TEST(Library, PathsAreUniqueAndStayInTheFolder) {
  for (const Model& model : example_models()) {
    for (const auto& files : {arduino_library(PreparedExport(model, {})), zephyr_module(PreparedExport(model, {}))}) {
      std::set<std::string> paths;
      for (const NamedText& file : files) {
        EXPECT_TRUE(paths.insert(file.path).second) << file.path;
        EXPECT_THAT(file.path, Not(testing::AnyOf(HasSubstr(".."), HasSubstr("NAME"), testing::EndsWith(".in"))));
        EXPECT_NE(file.path.front(), '/');
      }
    }
  }
}

TEST(Library, LibraryJsonIsValidAndNamesTheHeader) {
  const auto json = nlohmann::json::parse(text_of(arduino_library(PreparedExport(rig_model(), {})), "library.json"));
  EXPECT_EQ(json.at("headers"), "rig.h");
  EXPECT_EQ(json.at("name"), "rig");
}

TEST(Library, UserTextStaysInOneLine) {
  Model m = tiny_model();
  m.states[0].unit = "\"\n}\\\r\n#error";
  const auto files = arduino_library(PreparedExport(m, {}));
  EXPECT_TRUE(nlohmann::json::accept(text_of(files, "library.json")));
  EXPECT_THAT(text_of(files, "library.properties"), Not(HasSubstr("\n#error")));
  EXPECT_THAT(text_of(zephyr_module(PreparedExport(m, {})), "Kconfig"), Not(HasSubstr("\n#error")));
}

TEST(Library, HasAC99PairIfC99SupportsTheObserver) {
  const auto has = [](const std::vector<NamedText>& files, const std::string& word) {
    return std::ranges::any_of(files, [&](const NamedText& file) { return file.path.find(word) != std::string::npos; });
  };
  EXPECT_TRUE(has(arduino_library(PreparedExport(tiny_model(), {})), "tiny_c99.c"));
  EXPECT_TRUE(has(zephyr_module(PreparedExport(tiny_model(), {})), "src/tiny_c99.c"));
  EXPECT_TRUE(has(arduino_library(PreparedExport(driven_model(), {})), "driven_c99.c"));
}

}  // namespace
}  // namespace nlo::codegen
