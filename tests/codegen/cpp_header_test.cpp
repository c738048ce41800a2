// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_header.h"
#include "codegen/model/activations.h"
#include "codegen/targets/target_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/fold/fold.h"
#include "codegen/reference/reference_network.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/cpp_cost.h"
#include "codegen/targets/golden_replay.h"
#include "codegen/text/generated_text.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/golden.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string error_of(const Model& model, const ExportOptions& options = {}) {
  return thrown_message([&] { cpp_header(PreparedExport(model, options)); });
}

/// Returns all files of an export, one after the other.
std::string text_of(const ExportTarget& target, const Model& model, const ExportOptions& options = {}) {
  std::string text;
  for (const NamedText& file : target.generate(PreparedExport(model, options))) text += file.path + "\n" + file.text;
  return text;
}

TEST(Export, GivesTheSameBytesTwiceAndInAnyLocale) {
  for (const ExportTarget& target : export_targets()) {
    const std::string first = text_of(target, rig_model());
    EXPECT_EQ(text_of(target, rig_model()), first);
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr && std::setlocale(LC_ALL, "C.UTF-8") == nullptr) continue;
    EXPECT_EQ(text_of(target, rig_model()), first);
    std::setlocale(LC_ALL, "C");
  }
}

/// Returns the comment at the start of a file, up to its code example.
std::vector<std::string> head_of(const std::string& text) {
  std::istringstream lines(text);
  std::vector<std::string> head;
  for (std::string line; std::getline(lines, line) && line.starts_with("//") && line != "// Use";) head.push_back(line);
  return head;
}

TEST(Export, CommentsOfGeneratedFilesFitAHundredColumns) {
  Model model = rig_model();
  model.states[0].unit = "a_unit_of_20_letters";
  model.sample_period_s = 1.0 / 3.0;
  for (const char* target : {"cpp", "c99", "single"}) {
    const std::vector<NamedText> files = export_target(target).generate(PreparedExport(model, {}));
    for (const NamedText& file : files)
      for (const std::string& line : head_of(file.text)) EXPECT_LE(line.size(), 100U) << file.path << ": " << line;
    EXPECT_THAT(files.front().text, HasSubstr("sampled every 0.3333 s."));
  }
}

TEST(GeneratedText, BreaksALongCommentAtASpaceAndKeepsItsWords) {
  std::string words = "//   list";
  for (int i = 0; i < 60; ++i) words += " word" + std::to_string(i);
  const std::string wrapped = wrapped_comment(words + "\n// short\n");
  std::istringstream lines(wrapped);
  std::string joined;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 100U);
    EXPECT_TRUE(line.starts_with("//"));
    joined += (joined.empty() ? "" : " ") + line.substr(line.find_first_not_of("/ "));
  }
  EXPECT_EQ(joined, words.substr(5) + " short");
  EXPECT_EQ(wrapped_comment("// " + std::string(120, 'x') + "\n"), "// " + std::string(120, 'x') + "\n")
      << "a word that does not fit is not broken";
}

TEST(Export, ErrorsOfUnknownTargetsAndScalarsListTheKnownOnes) {
  EXPECT_THROW(
      try { export_target("fortran"); } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("cpp, replay"));
        throw;
      },
      Error);
  EXPECT_THROW(scalar_type("half"), Error);
}

/// Returns each network of a model, with its folded form.
std::vector<std::pair<Network, FoldedNetwork>> networks_of(const Model& m) {
  const FoldedModel f = fold(m);
  std::vector<std::pair<Network, FoldedNetwork>> list;
  for (const Named<const Network>& n : networks(m)) list.emplace_back(*n.network, f.network(n.field));
  return list;
}

TEST(Fold, ChangesNoNetwork) {
  constexpr double kTolerance = 1e-11;  // rounding of double, for feature and output scales up to 20
  for (const Model& m : example_models()) {
    for (const auto& [network, folded] : networks_of(m)) {
      const ReferenceNetwork<double> exact(network);
      for (int k = 0; k < 20; ++k) {
        const Eigen::VectorXd in = Eigen::VectorXd::LinSpaced(network.inputs(), -0.1 * k, 0.15 * k);
        const Eigen::VectorXd read = with_products<Eigen::VectorXd>(folded.products, in.head(folded.inputs()));
        Eigen::VectorXd a = read;
        for (std::size_t l = 0; l < folded.layers.size(); ++l) {
          a = (folded.layers[l].weights * a + folded.layers[l].bias).eval();
          if (l + 1 == folded.layers.size()) continue;
          a = a.unaryExpr(activation_row(folded.activation).value).eval();
        }
        if (folded.linear_path.size() != 0) a += folded.linear_path * read;
        fall_back(folded.fallback, read, a);
        ASSERT_LT((a - exact(in)).cwiseAbs().maxCoeff(), kTolerance) << m.name;
      }
    }
  }
}

TEST(Fold, ReadsTheOutputOnlyIfAFeatureDoes) {
  EXPECT_FALSE(fold(tiny_model()).inverse_map()->inputs() > 2);
  EXPECT_TRUE(fold(rig_model()).inverse_map()->inputs() > 7);
}

TEST(Fold, MergesTheLinearPathIntoASingleLayer) {
  Model m = linear_model();
  inverse_map(m)->skip = Eigen::MatrixXd::Constant(2, 2, 0.3);
  EXPECT_EQ(fold(m).inverse_map()->linear_path.size(), 0);
  EXPECT_NE(fold(m).inverse_map()->layers[0].weights, fold(linear_model()).inverse_map()->layers[0].weights);
}

TEST(CppHeader, UserTextCannotEndOrContinueAComment) {
  Model m = tiny_model();
  m.outputs[0].unit = "m\n#error unit\\";
  m.provenance = {{"a\n#error key", "1"},          {"escape", "ends with \\"}, {"trigraph", "ends with ?\?/"},
                  {"return", "a\r#error"},         {"block", "*/ #error /*"},  {"unicode", "\xe2\x80\xa8#error"},
                  {"long", std::string(5000, 'x')}};
  const std::string header = cpp_header(PreparedExport(m, {}));
  std::istringstream lines(header);
  std::size_t comment_lines = 0;
  for (std::string line; std::getline(lines, line) && line != "#pragma once"; ++comment_lines) {
    EXPECT_EQ(line.substr(0, 2), "//") << line;
    EXPECT_LT(line.size(), 130U);
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~' && c != '\\') << line;
  }
  EXPECT_GT(comment_lines, 15U);
  EXPECT_THAT(header, Not(HasSubstr("\n#error")));
}

TEST(CppHeader, RefusesNumbersBeyondFloat) {
  Model m = luenberger_model();  // its z has no known bound: the runtime checks it in each step
  Network& g = std::get<Luenberger>(m.structure).nonlinearity;
  g.layers[0].weights(2, 1) = 1e39;
  EXPECT_THAT(error_of(m), testing::AllOf(HasSubstr("layers[0]."), HasSubstr("exceeds the range of float")));
  EXPECT_EQ(error_of(m, {.name = "", .scalar = ScalarType::kDouble}), "no error");
  g.output_scale(0) = 1e300;
  g.layers[1].weights(0, 0) = 1e300;
  EXPECT_THAT(error_of(m, {.name = "", .scalar = ScalarType::kDouble}), HasSubstr("overflows"));
  m = tiny_model();
  m.sample_period_s = 1e-29;
  EXPECT_THAT(error_of(m), HasSubstr("|A| = 1"));
}

TEST(CppHeader, RefusesInvalidModels) {
  Model m = tiny_model();
  linear_latent(m)->eigenvalues(1) = 0.5;
  EXPECT_THAT(error_of(m), HasSubstr("eigenvalues[1] is 0.5; its real part must be negative"));
}

TEST(CppHeader, RefusesNamesThatAreNotIdentifiersOrAreTaken) {
  for (const char* name : {"class", "std", "9lives", "a-b", "a b", "", "../x", "a__b", "Vector", "make_mlp", "x\n"})
    EXPECT_EQ(error_of(tiny_model(), {.name = name}) == "no error", *name == '\0') << name;
}

TEST(CppHeader, RefusesEveryNameOfTheRuntime) {
  // Each declaration at the left margin of a runtime header is in the namespace that was opened last.
  const std::regex opened("^namespace nlo(?:::inline NLO_ISA)?(?:::(\\w+))?[\\w:]* \\{");
  const std::regex named("^(?:struct|class|enum class|using|concept) (\\w+)");
  const std::regex function("^(?:[A-Za-z_][\\w:<>*&, ]* )(\\w+)\\(");
  const std::regex constant("^inline constexpr [\\w:<>, ]+ (\\w+) =");
  std::set<std::string> names;
  for (const auto& file : std::filesystem::recursive_directory_iterator(NLO_SOURCE_DIR "/runtime/include/nlo")) {
    if (file.path().extension() != ".h") continue;
    std::istringstream lines(read_file(file.path().string()));
    std::string inner;  // the namespace inside nlo that is open
    for (std::string line; std::getline(lines, line);) {
      std::smatch match;
      if (std::regex_search(line, match, opened)) {
        inner = match[1];
        if (!inner.empty()) names.insert(inner);
      }
      for (const std::regex& pattern : {named, function, constant})
        if (inner.empty() && std::regex_search(line, match, pattern)) names.insert(match[1]);
    }
  }
  EXPECT_TRUE(names.contains("KklObserver") && names.contains("make_mlp") && names.contains("kTanhMaxError") &&
              names.contains("kRk4"));
  for (const std::string& name : names)
    EXPECT_NE(error_of(tiny_model(), {.name = name}), "no error") << name << " is missing in generated_text.cpp";
}

TEST(CppHeader, CommentsKeepPlainTextAndDropCharactersThatEndThem) {
  EXPECT_EQ(safe_comment("azAZ09 .,:;()[]+-=_/%<>^*|'#@&~", 100), "azAZ09 .,:;()[]+-=_/%<>^*|'#@&~");
  EXPECT_EQ(safe_comment("a\\\n?\t`{\xc3\xa9", 100), "a________");
  EXPECT_EQ(safe_comment("abc", 2), "ab");
}

TEST(CppHeader, HasTheErrorHeadOrStatesThatItIsLeftOut) {
  const Model m = with_error(rig_model(), 71);
  const std::string text = cpp_header(PreparedExport(m, {}));
  EXPECT_THAT(text, HasSubstr("const auto [x_hat, sigma, bound_95] = observer.estimate_with_error();"));
  EXPECT_THAT(text, HasSubstr(".error = {.layer = pack(weights::kErrorHead)"));
  ExportOptions in_int16;
  in_int16.scalar = ScalarType::kInt16;
  const std::string int16 = cpp_header(PreparedExport(m, in_int16));
  EXPECT_THAT(int16, HasSubstr("estimate_with_error() is left out"));
  EXPECT_THAT(int16, Not(HasSubstr("rrorHead")));
  const std::string c = c99(PreparedExport(m, {})).front().text;
  EXPECT_THAT(c, HasSubstr("standard deviations of its errors are left out"));
  EXPECT_THAT(cpp_header(PreparedExport(rig_model(), {})), Not(HasSubstr("sigma")));
}

TEST(CppHeader, EqualsItsGoldenFile) {
  expect_golden(cpp_header(PreparedExport(tiny_model(), {})), "tiny.h");
  expect_golden(cpp_header(PreparedExport(watched_model(), {})), "watched.h");
}

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(CppHeader, ComputesTheSineAndTheCosineOfAnArgumentByOneCall) {
  const std::string header = cpp_header(PreparedExport(hidden_joint_model(), {}));
  EXPECT_EQ(count_of(header, " = circle("), 3) << "of both angles and of their sum";
  EXPECT_EQ(count_of(header, "sine("), 0);  // "cosine(", too
}

TEST(CppHeader, ForADrivenObserverEqualsItsGoldenFile) {
  expect_golden(cpp_header(PreparedExport(driven_model(), {})), "driven.h");
}

TEST(CppHeader, Int16EqualsItsGoldenFile) {
  ExportOptions options;
  options.scalar = ScalarType::kInt16;
  expect_golden(cpp_header(PreparedExport(tiny_model(), options)), "tiny_int16.h");
}

TEST(CortexM4Time, BoundsTheCountedInstructionsOfEveryStructure) {
  struct Counted {
    const char* structure;
    Eigen::Index multiply_adds, activations;
    double fast, deterministic;  // instructions on an emulated M4F: docs/performance.md
  };
  const std::vector<Counted> all = {
      {"network relu", 7750, 200, 9342, 9442},  {"network tanh", 7750, 200, 10958, 12406},
      {"gated", 4256, 128, 6326, 7994},         {"GRU", 20480, 192, 26927, 32615},
      {"prior", 2896, 88, 7674, 8710},          {"carried", 182, 0, 1606, 2273},
      {"Luenberger", 824, 200, 4665, 5296},     {"general", 1698, 250, 6934, 7662},
      {"driven KKL", 15416, 384, 31999, 34444},
  };
  for (const Counted& counted : all) {
    CppCost cost;
    cost.step_multiply_adds = counted.multiply_adds;
    cost.estimate_activations = counted.activations;
    const auto m = static_cast<double>(counted.multiply_adds);
    const Microseconds time = cortex_m4_time(cost, 2.0);
    EXPECT_LE(2.0 * time.least, counted.fast + m) << counted.structure;
    EXPECT_GE(2.0 * time.most, counted.deterministic + 3.0 * m) << counted.structure;
  }
}

TEST(CortexM4Time, BoundsTheCountedInstructionsOfAFilter) {
  constexpr double kFast = 7490, kDeterministic = 8517;  // the row "filter" of docs/performance.md, the same model
  CppCost cost = cpp_cost(PreparedExport(hidden_joint_model(), {}));
  const auto m = static_cast<double>(cost.multiply_adds());
  EXPECT_LE(2.0 * cortex_m4_time(cost, 2.0).least, kFast + m);
  EXPECT_GE(2.0 * cortex_m4_time(cost, 2.0).most, kDeterministic + 3.0 * m);

  cost.further_instructions = 0;  // the control: multiply-adds and activations are not enough for equations
  EXPECT_LT(2.0 * cortex_m4_time(cost, 2.0).most, kDeterministic + 3.0 * m);
}

TEST(Replay, EqualsItsGoldenFile) {
  ExportOptions options;
  options.samples = 40;
  // Tolerances are measured on the machine that exports: its vector width determines the order of sums.
  const std::string text = replay(PreparedExport(tiny_model(), options));
  expect_golden(std::regex_replace(text, std::regex("(Tolerance\\[\\d+\\] = )\\{[^}]*\\}"), "$1{}"), "tiny_replay.h");
}

TEST(Replay, ContainsEveryStatusAndEveryKindOfStep) {
  const std::string text = replay(PreparedExport(rig_model(), {}));
  for (const char* tried : {"kOk", "kHeld", "kStale", "kClamped", "kMissed}"}) EXPECT_THAT(text, HasSubstr(tried));
  ExportOptions other;
  other.seed = 2;
  EXPECT_NE(replay(PreparedExport(rig_model(), other)), text);
  other.samples = 3;
  EXPECT_THROW(replay(PreparedExport(rig_model(), other)), Error);
}

TEST(Replay, AlsoContainsInputs) {
  const std::string text = replay(PreparedExport(driven_model(), {}));
  EXPECT_THAT(text, HasSubstr("float u[2];"));
  EXPECT_THAT(text, HasSubstr("{kMissed, "));
  EXPECT_THAT(replay(PreparedExport(rig_model(), {})), Not(HasSubstr(" u[")));
}

}  // namespace
}  // namespace nlo::codegen
