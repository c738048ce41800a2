// SPDX-License-Identifier: MIT
// Nobody asks which structure an observer has but the structures' own files and their tables: what differs between
// structures is a question to a module. A fifth structure then changes no other file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kRoot = NLO_SOURCE_DIR;

/// Code that asks, with the structures that there are.
const std::vector<std::string> kQuestions = {
    R"re([!=]=\s*"(kkl|driven_kkl|luenberger|general)")re",                  // structure == "kkl"
    R"re("(kkl|driven_kkl|luenberger|general)"\s*[!=]=)re",                  // and turned round
    R"re(\bget(_if)?<\s*(\w+::)*(Kkl|DrivenKkl|Luenberger|General)\s*>)re",  // std::get_if<codegen::Kkl>
    R"re(\bholds_alternative<\s*(\w+::)*(Kkl|DrivenKkl|Luenberger|General)\s*>)re",
    R"re(\bstructure\w*\s*(\.|->)\s*(index\(\)|kind\b))re",       // model.structure.index(), structure.kind
    R"re(\bvisit\(.*\bstructure\b)re",                            // std::visit(..., model.structure)
    R"re(\b(is_kkl|is_driven|is_luenberger|is_general)\s*\()re",  // a question with a name of its own
    R"re(\bStructureKind::)re",
    R"re(\b(dynamic_cast|typeid)\b[^;]*\b(Kkl\w*|DrivenKkl|Luenberger|General|StructureModule|TrainableStructure|module)\b)re",
    R"re(\b(kkl|driven_kkl|luenberger|general)_structure\(\))re",  // the module of one, by its name
};

/// Without comments, which may speak of structures. Text in quotes stays.
std::string code_of(const std::string& text) {
  std::string code;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quoted && text[i] == '\\') code += text[i++];
    if (text[i] == '"') quoted = !quoted;
    if (text[i] == '\n') quoted = false;
    if (!quoted && text.compare(i, 2, "//") == 0) i = std::min(text.find('\n', i), text.size() - 1);
    code += text[i];
  }
  return code;
}

/// Cheap to look for, and part of every question: a line without any is not searched.
bool may_ask(const std::string& line) {
  constexpr std::array kWords = {"kkl",     "Kkl",     "luenberger", "Luenberger",
                                 "general", "General", "structure",  "Structure"};
  return std::ranges::any_of(kWords, [&](const char* word) { return line.find(word) != std::string::npos; });
}

/// "LINE: the question", for each that a source text asks.
std::vector<std::string> questions(const std::string& text) {
  static const std::vector<std::regex> kPatterns(kQuestions.begin(), kQuestions.end());
  std::vector<std::string> found;
  std::istringstream lines(code_of(text));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!may_ask(line)) continue;
    for (const std::regex& pattern : kPatterns)
      if (std::smatch match; std::regex_search(line, match, pattern))
        found.push_back(std::to_string(number) + ": " + match.str());
  }
  return found;
}

/// A file that may know its structure: in codegen all of the structures' folder, in the trainer the file that defines a
/// module, and both tables.
bool is_structures_own(const std::string& file, const std::string& text) {
  if (file.starts_with("codegen/structures/") || file == "trainer/structures/table.cpp") return true;
  static const std::regex kModule(R"re(const TrainableStructure& \w+_structure\(\) \{)re");
  return file.starts_with("trainer/structures/") && std::regex_search(text, kModule);
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(StructureQuestions, AreAskedOfModulesAlone) {
  std::vector<std::string> asked;
  int files = 0, modules = 0;
  for (const char* folder : {"trainer", "codegen"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".inc") continue;
      const std::string file = entry.path().lexically_relative(kRoot).generic_string(), text = text_of(entry.path());
      ++files;
      if (is_structures_own(file, text)) {
        ++modules;
        continue;
      }
      for (const std::string& question : questions(text)) asked.push_back(file + ":" + question);
    }
  ASSERT_GT(files, 100) << "the scan has lost its way: " << kRoot;
  ASSERT_GT(modules, 4) << "the modules have other names now: who else is let through?";
  std::string report;
  for (const std::string& line : asked) report += line + "\n";
  EXPECT_THAT(asked, IsEmpty()) << report;
}

// The controls: each kind of question is seen, with its line; what merely speaks of structures is none.
TEST(StructureQuestions, AreSeenInEachOfTheirForms) {
  for (const char* code :
       {"if (o.structure == \"kkl\") f();", "return name != \"driven_kkl\";", "if (\"general\" == name) f();",
        "auto* l = std::get_if<Luenberger>(&model.structure);", "std::get<codegen::DrivenKkl>(m.structure).inputs",
        "std::holds_alternative<General>(m.structure)", "switch (structure.kind) {", "switch (model.structure.index())",
        "std::visit([](auto& s) { f(s); }, m.structure);", "structure_->is_kkl() && r < 3", "case StructureKind::kKkl:",
        "dynamic_cast<const KklFamily*>(structure.module)", "return &luenberger_structure();"}) {
    SCOPED_TRACE(code);
    EXPECT_THAT(questions(std::string("\n") + code), ElementsAre(HasSubstr("2: ")));
  }
  EXPECT_THAT(questions("// structure == \"kkl\"\nf(\"take structure = \\\"kkl\\\"\");\nmodule.has_eigenvalues();"),
              IsEmpty());
  EXPECT_THAT(questions("x = \"//\"; y = s == \"kkl\";"), ElementsAre(HasSubstr("1: ")));
}

TEST(StructureQuestions, MayBeAskedInAModule) {
  const std::string module = "const TrainableStructure& x_structure() {\n";
  EXPECT_TRUE(is_structures_own("trainer/structures/x.cpp", module));
  EXPECT_FALSE(is_structures_own("trainer/structures/structure.cpp", "std::vector<float> initial_dynamics()"));
  EXPECT_FALSE(is_structures_own("trainer/losses/x.cpp", module));
}

}  // namespace
