// SPDX-License-Identifier: MIT
// Allowed directions of includes: trainer -> codegen -> runtime -> Eigen, a generated header -> runtime, bench and
// examples -> runtime, bindings -> codegen, nothing -> tests. The runtime uses only headers that a freestanding
// compiler has. The folders of runtime, codegen and trainer form no cycle. docs/architecture.svg shows these arrows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/properties/include_rules.h"

namespace {

namespace fs = std::filesystem;
using namespace nlo::properties;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kRoot = NLO_SOURCE_DIR;

struct Include {
  std::string target;  ///< as written, without quotes or brackets
  bool quoted = false;
  int line = 0;
};

std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(kRoot / file).rdbuf();
  return text.str();
}

bool starts_with_any(std::string_view text, const auto& prefixes) {
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

/// The folders that the build under sanitizers leaves out of the trainer, as trainer/CMakeLists.txt lists them.
const std::vector<std::string>& folders_left_out() {
  static const std::vector<std::string> found = [] {
    std::istringstream lines(text_of("trainer/CMakeLists.txt"));
    std::vector<std::string> folders;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string list, append, name;
      if (!(words >> list >> append >> name) || list != "list(APPEND" || append != "folders") continue;
      do folders.push_back("trainer/" + name.substr(0, name.find(')')) + "/");
      while (words >> name);
    }
    return folders;
  }();
  return found;
}

/// Returns why `file` (path from the root) must not include this; empty if it may.
std::string objection(const std::string& file, const Include& include) {
  const Arrow* arrow = nullptr;
  for (const Arrow& candidate : kArrows) {
    if (file.starts_with(candidate.from) && (!arrow || candidate.from.size() > arrow->from.size())) arrow = &candidate;
  }
  if (!arrow) return "is in a folder without a rule; add one to kArrows";

  static const std::vector<std::string_view> kParts = {"nlo/",   "codegen/", "trainer/", "bindings/",
                                                       "tests/", "bench/",   "examples/"};
  const bool ours = starts_with_any(include.target, kParts);
  if (ours && !starts_with_any(include.target, arrow->may)) return "is an arrow against the layering";
  for (const Wall& wall : kWalls) {
    if (file.starts_with(wall.from) && !file.starts_with(wall.target) && include.target.starts_with(wall.target)) {
      return "crosses the wall between " + std::string(wall.from) + " and " + std::string(wall.target);
    }
  }
  if (file.starts_with("trainer/") && file != "trainer/app/main.cpp" && !starts_with_any(file, folders_left_out()) &&
      starts_with_any(include.target, folders_left_out())) {
    return "is what NLO_CORE_ONLY leaves out (trainer/CMakeLists.txt), in a file that it builds";
  }
  if (file.starts_with("runtime/") && !ours && !include.target.starts_with("Eigen/") &&
      std::ranges::find(kRuntimeStandardHeaders, include.target) == kRuntimeStandardHeaders.end()) {
    return "is not a header that every target of the runtime has";
  }
  // Examples and user programs include their generated header, which is not in a source folder; a golden C file
  // includes its own header.
  if (include.quoted && !starts_with_any(file, std::array{"examples/", "tests/install/", "tests/golden/"}) &&
      !fs::exists(kRoot / include.target) && !fs::exists(kRoot / "runtime/include" / include.target)) {
    return "is quoted but is not a file of this project seen from its root";
  }
  return "";
}

const Exception* exception_for(const std::string& file, const Include& include) {
  const auto found = std::ranges::find_if(kExceptions, [&](const Exception& exception) {
    return file.starts_with(exception.file) && include.target == exception.target;
  });
  return found == kExceptions.end() ? nullptr : &*found;
}

std::vector<std::string> violations(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  for (const Include& include : includes_of(text)) {
    const std::string reason = objection(file, include);
    if (!reason.empty() && exception_for(file, include) == nullptr)
      found.push_back(file + ":" + std::to_string(include.line) + ": " + include.target + " " + reason);
  }
  return found;
}

std::vector<std::string> source_files() {
  std::vector<std::string> files;
  for (const char* folder : {"runtime", "codegen", "trainer", "bindings", "tests", "bench", "examples"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp" || extension == ".c" || extension == ".inc") {
        files.push_back(entry.path().lexically_relative(kRoot).generic_string());
      }
    }
  }
  return files;
}

std::string lines(const std::vector<std::string>& all) {
  std::string text;
  for (const std::string& line : all) text += line + "\n";
  return text;
}

/// The folders that each folder includes.
using Rooms = std::map<std::string, std::set<std::string>>;

std::string folder_of(std::string_view path) {
  return std::string(path.substr(0, path.rfind('/')));
}

/// Returns a cycle as "a -> b -> a"; empty if there is none.
std::string circle_in(const Rooms& rooms) {
  std::set<std::string> done;
  std::vector<std::string> path;
  std::string circle;
  const auto visit = [&](const auto& self, const std::string& room) -> void {
    const auto before = std::ranges::find(path, room);
    if (before != path.end()) {
      for (auto step = before; step != path.end(); ++step) circle += *step + " -> ";
      circle += room;
    }
    if (!circle.empty() || !done.insert(room).second) return;
    path.push_back(room);
    if (const auto entry = rooms.find(room); entry != rooms.end())
      for (const std::string& next : entry->second)
        if (circle.empty()) self(self, next);
    path.pop_back();
  };
  for (const auto& entry : rooms) visit(visit, entry.first);
  return circle;
}

TEST(IncludeArrows, HaveAllowedDirectionsInEveryFile) {
  const auto files = source_files();
  ASSERT_GT(files.size(), 10U) << "the scan found too few files below " << kRoot;
  EXPECT_THAT(files, Contains(testing::EndsWith(".inc")));
  std::vector<std::string> all;
  for (const std::string& file : files) std::ranges::copy(violations(file, text_of(file)), std::back_inserter(all));
  EXPECT_THAT(all, IsEmpty()) << lines(all);
}

TEST(IncludeArrows, UseEveryListedException) {
  std::set<const Exception*> needed;
  for (const std::string& file : source_files()) {
    for (const Include& include : includes_of(text_of(file)))
      if (!objection(file, include).empty()) needed.insert(exception_for(file, include));
  }
  for (const Exception& exception : kExceptions)
    EXPECT_TRUE(needed.contains(&exception))
        << exception.file << " no longer includes " << exception.target << ": remove its line from kExceptions";
  for (const Arrow& arrow : kArrows)
    EXPECT_TRUE(std::ranges::any_of(source_files(), [&](const auto& file) { return file.starts_with(arrow.from); }))
        << "kArrows: there is no file below " << arrow.from;
  for (const Wall& wall : kWalls)
    EXPECT_TRUE(fs::exists(kRoot / wall.from) && fs::exists(kRoot / wall.target)) << wall.from << " | " << wall.target;
}

TEST(IncludeArrows, FormNoCycleOfFolders) {
  constexpr std::string_view kRuntime = "runtime/include/";
  Rooms rooms;
  for (const std::string& file : source_files()) {
    if (!starts_with_any(file, std::array{"trainer/", "codegen/", "runtime/"})) continue;
    for (const Include& include : includes_of(text_of(file))) {
      const std::string from = folder_of(file.starts_with(kRuntime) ? file.substr(kRuntime.size()) : file);
      if (starts_with_any(include.target, std::array{"trainer/", "codegen/", "nlo/"}) &&
          folder_of(include.target) != from && exception_for(file, include) == nullptr)
        rooms[from].insert(folder_of(include.target));
    }
  }
  ASSERT_GT(rooms.size(), 10U);
  EXPECT_THAT(rooms["nlo"], Contains("nlo/kernels"));
  EXPECT_THAT(rooms["nlo/kernels"], Contains("nlo/kernels/per_isa"));
  EXPECT_EQ(circle_in(rooms), "");
}

/// Returns the pairs of files that have the same name.
std::vector<std::string> equal_names_in(const std::vector<std::string>& files) {
  std::map<std::string, std::string> file_of;
  std::vector<std::string> equal;
  for (const std::string& file : files) {
    const auto [first, is_new] = file_of.emplace(fs::path(file).filename().string(), file);
    if (!is_new) equal.push_back(first->second + " and " + file);
  }
  return equal;
}

TEST(FileNames, AreUniqueInTheRuntimeTheGeneratorAndTheTrainer) {
  std::vector<std::string> files = source_files();
  std::erase_if(files, [](const std::string& file) {
    return !starts_with_any(file, std::array{"runtime/", "codegen/", "trainer/"});
  });
  ASSERT_GT(files.size(), 10U);
  const auto equal = equal_names_in(files);
  EXPECT_THAT(equal, IsEmpty()) << lines(equal);
}

TEST(FileNames, EqualNamesAreDetected) {
  EXPECT_THAT(equal_names_in({"a/x.h", "b/y.h", "b/x.h", "a/x.cpp"}), ElementsAre("a/x.h and b/x.h"));
}

TEST(IncludeArrows, DetectACycleOfFolders) {
  EXPECT_EQ(circle_in({{"a", {"b", "c"}}, {"b", {"d"}}, {"c", {"d"}}}), "");
  EXPECT_EQ(circle_in({{"a", {"b"}}, {"b", {"c", "d"}}, {"d", {"b"}}}), "b -> d -> b");
}

// Controls: each kind of forbidden include is reported with its line, and an allowed include is not.
TEST(IncludeArrows, DetectAnIncludeAgainstTheLayering) {
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#pragma once\n#include \"codegen/model/model.h\"\n"),
              ElementsAre(HasSubstr("nlo/x.h:2: codegen/model/model.h is an arrow against")));
  EXPECT_THAT(violations("codegen/x.cpp", "#include \"trainer/config/experiment.h\"\n"),
              ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("trainer/x.cpp", "  #  include <tests/x.h>  // why not\n"), ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("bench/step_latency.cpp", "#include \"trainer/config/experiment.h\""),
              ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("bench/training_epoch.cpp", "#include \"trainer/config/experiment.h\""), IsEmpty());
  EXPECT_THAT(violations("trainer/x.cpp", "#include \"codegen/model/model.h\"\n#include <nlo/latent.h>\n"), IsEmpty());
  EXPECT_THAT(violations("trainer/x.cpp", "// #include \"tests/x.h\" is what one must not do\n"), IsEmpty());
}

TEST(IncludeArrows, DetectALossThatIncludesAStructureOrAPlant) {
  EXPECT_THAT(violations("trainer/learn/losses/x.cpp", "#include <trainer/structures/kkl.h>"),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("trainer/gradients/sensitivity/x.h", "#include <trainer/plants/plant.h>"),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("trainer/learn/losses/x.h", "#include \"trainer/structures/observer_structure.h\""),
              IsEmpty());
}

TEST(IncludeArrows, DetectACommandThatIncludesTheReproduction) {
  EXPECT_THAT(violations("trainer/app/commands/x.cpp", "#include \"trainer/reproduce/run.h\""),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("trainer/reproduce/x.cpp", "#include \"trainer/app/commands/command.h\""), IsEmpty());
}

TEST(IncludeArrows, DetectConfigThatIncludesADomain) {
  EXPECT_THAT(violations("trainer/config/x.cpp", "#include \"trainer/plants/plant_registry.h\""),
              ElementsAre(HasSubstr("against")));
  EXPECT_THAT(violations("codegen/x.cpp", "#include \"codegen/targets/target_registry.h\""),
              ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(violations("codegen/targets/x.cpp", "#include \"codegen/targets/target_registry.h\""), IsEmpty());
}

TEST(IncludeArrows, DetectAFileOfTheSanitizedBuildThatIncludesALeftOutFolder) {
  EXPECT_THAT(folders_left_out(), Contains("trainer/judge/"));
  EXPECT_THAT(violations("trainer/experiments/x.cpp", "#include \"trainer/judge/evaluation/closed_loop.h\"\n"),
              ElementsAre(HasSubstr("NLO_CORE_ONLY leaves out")));
  EXPECT_THAT(violations("trainer/judge/monitor/x.cpp", "#include \"trainer/judge/evaluation/closed_loop.h\"\n"),
              IsEmpty());
  EXPECT_THAT(violations("trainer/experiments/x.cpp", "#include \"trainer/data/dataset.h\"\n"), IsEmpty());
}

TEST(IncludeArrows, DetectAHostedHeaderInTheRuntime) {
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#include <cmath>\n#include <vector>\n#include <cstdint>\n"),
              ElementsAre(HasSubstr(":1: cmath"), HasSubstr(":2: vector")));
  EXPECT_THAT(violations("runtime/include/nlo/x.h", "#include <Eigen/Core>\n"), IsEmpty());
}

TEST(IncludeArrows, DetectAPathThatIsNotRelativeToTheRoot) {
  EXPECT_THAT(violations("codegen/x.cpp", "#include \"model.h\"\n"), ElementsAre(HasSubstr("from its root")));
  EXPECT_THAT(violations("elsewhere/x.cpp", "#include <vector>\n"), ElementsAre(HasSubstr("without a rule")));
}

}  // namespace
