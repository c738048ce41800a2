// SPDX-License-Identifier: MIT
// Only the files of the structures and their tables may ask which structure an observer has; other code calls the
// structure's module. A new structure then changes no other file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
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

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Returns the types of codegen::Structure from its declaration, so that a new type is included at once.
std::vector<std::string> structure_types() {
  const std::string text = text_of(kRoot / "codegen/model/structures.h");
  std::smatch list;
  std::vector<std::string> types;
  if (!std::regex_search(text, list, std::regex(R"re(Structure = std::variant<([^>]*)>)re"))) return types;
  const std::string all = list[1];
  const std::regex word(R"re(\w+)re");
  for (std::sregex_iterator at(all.begin(), all.end(), word), end; at != end; ++at) types.push_back(at->str());
  return types;
}

/// DrivenKkl -> driven_kkl
std::string name_of(const std::string& type) {
  std::string name;
  for (const char c : type) {
    if (c >= 'A' && c <= 'Z' && !name.empty()) name += '_';
    name += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  }
  return name;
}

/// Joins texts; operator+ of a literal and a string gives wrong warnings about lengths in GCC 12.
std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text.append(part);
  return text;
}

/// Returns "(a|b|c)" of the names that `as` makes from each structure's type.
std::string any_structure(const std::function<std::string(const std::string&)>& as) {
  std::vector<std::string> parts;
  for (const std::string& type : structure_types()) {
    parts.emplace_back(parts.empty() ? "(" : "|");
    parts.push_back(as(type));
  }
  parts.emplace_back(")");
  return joined(parts);
}

/// Returns patterns of code that asks for the structure.
std::vector<std::string> question_patterns() {
  const std::string name = any_structure(name_of), type = any_structure([](const std::string&t) { return t; });
  return {
      joined({R"re([!=]=\s*")re", name, R"re(")re"}),                           // structure == "kkl"
      joined({R"re(")re", name, R"re("\s*[!=]=)re"}),                           // the same with the sides exchanged
      joined({R"re(\bget(_if)?<\s*(\w+::)*)re", type, R"re(\s*>)re"}),          // std::get_if<codegen::Kkl>
      joined({R"re(\bholds_alternative<\s*(\w+::)*)re", type, R"re(\s*>)re"}),  //
      R"re(\bstructure\w*\s*(\.|->)\s*(index\(\)|kind\b))re",                   // model.structure.index()
      R"re(\bvisit\(.*\bstructure\b)re",                                        // std::visit(..., model.structure)
      joined({R"re(\bis_(driven|)re", name.substr(1), R"re(\s*\()re"}),         // a function that asks
      R"re(\bStructureKind::)re",
      joined({R"re(\b(dynamic_cast|typeid)\b[^;]*\b(StructureModule|TrainableStructure|module|)re", type.substr(1),
              R"re(\w*\b)re"}),
      joined({R"re(\b)re", name, R"re(_structure\(\))re"}),  // the module of one structure, by its name
  };
}

/// Removes comments, which may name structures. Quoted text stays.
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

/// Returns "LINE: question" for each question in a source text.
std::vector<std::string> questions(const std::string& text) {
  static const std::vector<std::regex> kPatterns = [] {
    std::vector<std::regex> patterns;
    for (const std::string& pattern : question_patterns()) patterns.emplace_back(pattern);
    return patterns;
  }();
  // Each question contains one of these words; other lines are skipped quickly.
  static const std::vector<std::string> kWords = [] {
    std::vector<std::string> words = {"structure", "Structure", "is_driven"};
    for (const std::string& type : structure_types()) words.insert(words.end(), {type, name_of(type)});
    return words;
  }();
  const auto may_ask = [](const std::string& text_line) {
    return std::ranges::any_of(kWords,
                               [&](const std::string& word) { return text_line.find(word) != std::string::npos; });
  };
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

/// Returns true if a file may know its structure: in codegen the folder of structures, in the trainer each file that
/// defines a module, and both tables.
bool is_structures_own(const std::string& file, const std::string& text) {
  if (file.starts_with("codegen/structures/") || file == "trainer/structures/structure_table.cpp") return true;
  static const std::regex kModule(R"re(const TrainableStructure& \w+_structure\(\) \{)re");
  return file.starts_with("trainer/structures/") && std::regex_search(text, kModule);
}

TEST(StructureQuestions, AreAskedOnlyThroughModules) {
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
  ASSERT_GT(files, 100) << "the scan found too few files below " << kRoot;
  ASSERT_GT(modules, 4) << "the modules have other names: is_structures_own() may allow the wrong files";
  std::string report;
  for (const std::string& line : asked) report += line + "\n";
  EXPECT_THAT(asked, IsEmpty()) << report;
}

// Controls: each kind of question is found, with its line; code that only names structures is not reported.
TEST(StructureQuestions, AreDetectedInEachForm) {
  for (const char* code :
       {"if (o.structure == \"kkl\") f();", "return name != \"driven_kkl\";", "if (\"general\" == name) f();",
        "auto* l = std::get_if<Luenberger>(&model.structure);", "std::get<codegen::DrivenKkl>(m.structure).inputs",
        "std::holds_alternative<General>(m.structure)", "switch (structure.kind) {", "switch (model.structure.index())",
        "std::visit([](auto& s) { f(s); }, m.structure);", "structure_->is_kkl() && r < 3", "case StructureKind::kKkl:",
        "dynamic_cast<const KklFamily*>(structure.module)", "return &luenberger_structure();",
        "if (e.observer.structure == \"gated\") f();", "std::get_if<codegen::Gated>(&m.structure)",
        "auto& g = std::get<Gated>(model.structure);", "return is_gated(model);"}) {
    SCOPED_TRACE(code);
    EXPECT_THAT(questions(std::string("\n") + code), ElementsAre(HasSubstr("2: ")));
  }
  EXPECT_THAT(questions("// structure == \"kkl\"\nf(\"take structure = \\\"kkl\\\"\");\nmodule.has_eigenvalues();"),
              IsEmpty());
  EXPECT_THAT(questions("x = \"//\"; y = s == \"kkl\";"), ElementsAre(HasSubstr("1: ")));
}

TEST(StructureQuestions, AreAllowedInAModule) {
  const std::string module = "const TrainableStructure& x_structure() {\n";
  EXPECT_TRUE(is_structures_own("trainer/structures/x.cpp", module));
  EXPECT_FALSE(is_structures_own("trainer/structures/structure.cpp", "std::vector<float> initial_dynamics()"));
  EXPECT_FALSE(is_structures_own("trainer/learn/losses/x.cpp", module));
}

}  // namespace
