// SPDX-License-Identifier: MIT
// What is in the folders for package managers; compile_libraries.sh compiles them.
#include "codegen/targets/library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "codegen/base/file.h"
#include "tests/codegen/example_models.h"

namespace nlo::codegen {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::string text_of(const std::vector<NamedText>& files, const std::string& path) {
  for (const NamedText& file : files)
    if (file.path == path) return file.text;
  ADD_FAILURE() << "there is no " << path;
  return "";
}

TEST(Library, PacksTheRuntimeThatTheHeaderIncludesAndNoEigen) {
  const auto kkl = runtime_headers("#include <nlo/kkl_observer.h>");
  EXPECT_THAT(kkl, testing::IsSupersetOf({"nlo/kkl_observer.h", "nlo/vector.h", "nlo/kernels/per_isa/vectors.inc"}));
  EXPECT_THAT(kkl, Not(testing::AnyOf(Contains("nlo/eigen.h"), Contains("nlo/driven_kkl_observer.h"))));
  EXPECT_THAT(runtime_headers("#include <nlo/driven_kkl_observer.h>"), Contains("nlo/exponential_rk.h"));
  EXPECT_TRUE(runtime_headers("#include <string>").empty());
  EXPECT_THROW(runtime_headers("#include <nlo/none.h>"), std::logic_error) << "a header that is missing is seen here";
  const auto files = arduino_library(PreparedExport(tiny_model(), {}));
  EXPECT_EQ(text_of(files, "src/nlo/vector.h"), read_file(NLO_SOURCE_DIR "/runtime/include/nlo/vector.h"));
}

TEST(Library, EveryPathStaysInsideAndIsThereOnce) {
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

TEST(Library, JsonIsJsonAndNamesTheHeader) {
  const auto json = nlohmann::json::parse(text_of(arduino_library(PreparedExport(rig_model(), {})), "library.json"));
  EXPECT_EQ(json.at("headers"), "rig.h");
  EXPECT_EQ(json.at("name"), "rig");
}

TEST(Library, UserTextStaysInItsLine) {
  Model m = tiny_model();
  m.states[0].unit = "\"\n}\\\r\n#error";
  const auto files = arduino_library(PreparedExport(m, {}));
  EXPECT_TRUE(nlohmann::json::accept(text_of(files, "library.json")));
  EXPECT_THAT(text_of(files, "library.properties"), Not(HasSubstr("\n#error")));
  EXPECT_THAT(text_of(zephyr_module(PreparedExport(m, {})), "Kconfig"), Not(HasSubstr("\n#error")));
}

TEST(Library, HasAC99PairForObserversThatHaveOne) {
  const auto has = [](const std::vector<NamedText>& files, const std::string& word) {
    return std::ranges::any_of(files, [&](const NamedText& file) { return file.path.find(word) != std::string::npos; });
  };
  EXPECT_TRUE(has(arduino_library(PreparedExport(tiny_model(), {})), "tiny_c99.c"));
  EXPECT_TRUE(has(zephyr_module(PreparedExport(tiny_model(), {})), "src/tiny_c99.c"));
  EXPECT_FALSE(has(arduino_library(PreparedExport(driven_model(), {})), "_c99"));
  EXPECT_THAT(text_of(zephyr_module(PreparedExport(driven_model(), {})), "Kconfig"), Not(HasSubstr("C99")));
  EXPECT_THAT(text_of(zephyr_module(PreparedExport(driven_model(), {})), "CMakeLists.txt"), Not(HasSubstr("_c99.c")));
}

}  // namespace
}  // namespace nlo::codegen
