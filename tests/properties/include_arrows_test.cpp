// SPDX-License-Identifier: MIT
// Which way includes may point: trainer -> codegen -> runtime -> Eigen, a generated header -> runtime, bench and
// examples -> runtime, nothing -> tests. The runtime stays on headers that a freestanding compiler has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kRoot = NLO_SOURCE_DIR;

struct Include {
  std::string target;  ///< as written, without quotes or brackets
  bool quoted = false;
  int line = 0;
};

/// Who may include what. The longest `from` that a file's path starts with decides; its `may` lists prefixes of
/// targets.
struct Arrow {
  std::string_view from;
  std::vector<std::string_view> may;
};

const std::vector<Arrow> kArrows = {
    {"runtime/", {"nlo/"}},
    {"codegen/", {"nlo/", "codegen/"}},
    {"trainer/", {"nlo/", "codegen/", "trainer/"}},
    {"bench/", {"nlo/", "bench/"}},
    {"bench/rt_loop", {"nlo/", "bench/", "examples/control_loop/"}},
    {"bench/training_", {"nlo/", "bench/", "trainer/", "codegen/"}},
    {"tests/", {"nlo/", "codegen/", "trainer/", "bench/", "examples/", "tests/"}},
    {"examples/", {"nlo/"}},
};

/// What a part of the trainer must not know: `from` never includes `target`, but for the files and the targets in `except`.
struct Wall {
  std::string_view from, target;
  std::vector<std::string_view> except;
};

const std::vector<Wall> kWalls = {
    // A loss term and a sensitivity speak in cotangents at samples: no structure's equations, no plant's.
    {"trainer/losses/", "trainer/structures/", {"trainer/structures/observer_structure.h"}},
    {"trainer/sensitivity/", "trainer/structures/", {}},
    {"trainer/losses/", "trainer/plants/", {"trainer/losses/pde_residual"}},
    {"trainer/sensitivity/", "trainer/plants/", {}},
    {"trainer/losses/", "trainer/sensitivity/", {}},
    {"trainer/sensitivity/", "trainer/losses/", {}},
    // The method needs data, not f.
    {"trainer/structures/", "trainer/plants/", {}},
    {"trainer/nn/", "trainer/plants/", {}},
    {"trainer/optim/", "trainer/plants/", {}},
    {"trainer/training/", "trainer/plants/", {}},
};

/// Standard headers that a freestanding or bare-metal C++20 compiler has, and that pull in neither libm nor the heap.
const std::vector<std::string_view> kRuntimeStandardHeaders = {
    "array",  "bit",   "compare",     "concepts", "cstddef", "cstdint",     "initializer_list",
    "limits", "tuple", "type_traits", "utility",  "version", "immintrin.h", "arm_neon.h"};

bool starts_with_any(std::string_view text, const std::vector<std::string_view>& prefixes) {
  return std::ranges::any_of(prefixes, [&](std::string_view prefix) { return text.starts_with(prefix); });
}

/// The #include lines of a source text.
std::vector<Include> includes_of(const std::string& text) {
  std::vector<Include> found;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::string_view rest = line;
    const auto skip = [&rest](std::string_view word) {
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
      const bool there = rest.starts_with(word);
      if (there) rest.remove_prefix(word.size());
      return there;
    };
    if (!skip("#") || !skip("include")) continue;
    const bool quoted = skip("\"");
    if (!quoted && !skip("<")) continue;
    found.push_back({std::string(rest.substr(0, rest.find(quoted ? '"' : '>'))), quoted, number});
  }
  return found;
}

/// Why `file` (path from the root) must not include this; empty when it may.
std::string objection(const std::string& file, const Include& include) {
  const Arrow* arrow = nullptr;
  for (const Arrow& candidate : kArrows) {
    if (file.starts_with(candidate.from) && (!arrow || candidate.from.size() > arrow->from.size())) arrow = &candidate;
  }
  if (!arrow) return "is in a folder without a rule; add one to kArrows";

  static const std::vector<std::string_view> kParts = {"nlo/", "codegen/", "trainer/", "tests/", "bench/", "examples/"};
  const bool ours = starts_with_any(include.target, kParts);
  if (ours && !starts_with_any(include.target, arrow->may)) return "is an arrow against the layering";
  for (const Wall& wall : kWalls) {
    if (file.starts_with(wall.from) && include.target.starts_with(wall.target) && !starts_with_any(file, wall.except) &&
        !starts_with_any(include.target, wall.except)) {
      return "crosses the wall between " + std::string(wall.from) + " and " + std::string(wall.target);
    }
  }
  if (file.starts_with("runtime/") && !ours && !include.target.starts_with("Eigen/") &&
      std::ranges::find(kRuntimeStandardHeaders, include.target) == kRuntimeStandardHeaders.end()) {
    return "is not a header that every target of the runtime has";
  }
  // An example includes the header that was generated for it, which stands in no source folder; a golden C file its
  // own.
  if (include.quoted && !file.starts_with("examples/") && !file.starts_with("tests/golden/") &&
      !fs::exists(kRoot / include.target) && !fs::exists(kRoot / "runtime/include" / include.target)) {
    return "is quoted but is no file of this project seen from its root";
  }
  return "";
}

std::vector<std::string> violations(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  for (const Include& include : includes_of(text)) {
    const std::string reason = objection(file, include);
    if (!reason.empty())
      found.push_back(file + ":" + std::to_string(include.line) + ": " + include.target + " " + reason);
  }
  return found;
}

std::vector<std::string> source_files() {
  std::vector<std::string> files;
  for (const char* folder : {"runtime", "codegen", "trainer", "tests", "bench", "examples"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp" || extension == ".c") {
        files.push_back(entry.path().lexically_relative(kRoot).generic_string());
      }
    }
  }
  return files;
}

TEST(IncludeArrows, PointTheAllowedWayInEveryFile) {
  const auto files = source_files();
  ASSERT_GT(files.size(), 10U) << "the scan has lost its way: " << kRoot;
  std::vector<std::string> all;
  for (const std::string& file : files) {
    std::ostringstream text;
    text << std::ifstream(kRoot / file).rdbuf();
    std::ranges::copy(violations(file, text.str()), std::back_inserter(all));
  }
  std::string report;
  for (const std::string& line : all) report += line + "\n";
  EXPECT_THAT(all, IsEmpty()) << report;
}

// The controls: each kind of forbidden include is seen, with its line, and its allowed twin is not.
TEST(IncludeArrows, SeeAnArrowAgainstTheLayering) {
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#pragma once\n#include \"codegen/model.h\"\n"),
              ElementsAre(HasSubstr("nlo/x.h:2: codegen/model.h is an arrow against")));
  EXPECT_THAT(violations("codegen/x.cpp", "#include \"trainer/config/experiment.h\"\n"),
              ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("trainer/x.cpp", "  #  include <tests/x.h>  // why not\n"), ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("bench/step_latency.cpp", "#include \"trainer/config/experiment.h\""),
              ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("bench/training_epoch.cpp", "#include \"trainer/config/experiment.h\""), IsEmpty());
  EXPECT_THAT(violations("trainer/x.cpp", "#include \"codegen/model.h\"\n#include <nlo/latent.h>\n"), IsEmpty());
  EXPECT_THAT(violations("trainer/x.cpp", "// #include \"tests/x.h\" is what one must not do\n"), IsEmpty());
}

TEST(IncludeArrows, SeeALossThatKnowsAStructureOrAPlant) {
  EXPECT_THAT(violations("trainer/losses/x.cpp", "#include <trainer/structures/kkl.h>"),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("trainer/sensitivity/x.h", "#include <trainer/plants/plant.h>"),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("trainer/losses/pde_residual.cpp", "#include <trainer/plants/plant.h>"), IsEmpty());
}

TEST(IncludeArrows, SeeAHostedHeaderInTheRuntime) {
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#include <cmath>\n#include <vector>\n#include <cstdint>\n"),
              ElementsAre(HasSubstr(":1: cmath"), HasSubstr(":2: vector")));
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#include <Eigen/Core>\n"), IsEmpty());
}

TEST(IncludeArrows, SeeAPathThatIsNotWrittenFromTheRoot) {
  EXPECT_THAT(violations("codegen/x.cpp", "#include \"model.h\"\n"), ElementsAre(HasSubstr("from its root")));
  EXPECT_THAT(violations("elsewhere/x.cpp", "#include <vector>\n"), ElementsAre(HasSubstr("without a rule")));
}

}  // namespace
