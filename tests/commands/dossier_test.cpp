// SPDX-License-Identifier: MIT
// nlo dossier as a user gives it: what it collects, what it refuses, and that its index tells the truth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/sha256.h"
#include "tests/commands/program.h"
#include "trainer/dossier/dossier_table.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A folder with a model of the tiny plant.
class DossierOfPlant : public testing::Test {
 protected:
  DossierOfPlant() {
    scratch_.write("tiny.toml", kTinyExperiment);
    scratch_.ok({"train", "tiny.toml", "-q", "-o", "a"});
  }
  void SetUp() override {
    if (std::string(NLO_CC).empty()) GTEST_SKIP() << "no C compiler here";
  }
  ProgramResult made(const std::string& folder, const std::string& model = "a/model.json") const {
    return scratch_.ok({"dossier", model, "-q", "-o", folder});
  }

  Scratch scratch_;
};

/// The commands of nlo that an index names.
std::vector<std::vector<std::string>> commands_in(const std::string& index) {
  static const std::regex kMade(R"(\[[a-z_.]+\]\(([a-z_.]+)\) \| .* \| `nlo ([^`]*)`)");
  std::vector<std::vector<std::string>> commands;
  for (std::sregex_iterator at(index.begin(), index.end(), kMade), end; at != end; ++at) {
    std::istringstream words((*at)[2].str());
    commands.push_back({(*at)[1].str()});
    for (std::string word; words >> word;) commands.back().push_back(word);
  }
  return commands;
}

TEST_F(DossierOfPlant, EveryFileIsWhatItsCommandGivesAgain) {
  made("d");
  const std::string index = scratch_.read("d/index.md");
  for (const DossierItem& item : dossier_table().items) {
    EXPECT_THAT(index, HasSubstr(item.file));
    const bool expected = item.needs.empty() || item.needs == "plant" || item.needs == "training";
    EXPECT_EQ(scratch_.has("d/" + item.file), expected) << item.file;
  }
  const auto commands = commands_in(index);
  EXPECT_EQ(commands.size(), 7U) << index;
  Scratch again;
  again.write("model.json", scratch_.read("d/model.json"));
  for (std::vector<std::string> words : commands) {
    const std::string file = words.front();
    words.erase(words.begin());
    EXPECT_EQ(again.ok(words).out, scratch_.read("d/" + file)) << file;
  }
  for (const char* file : {"export/tiny.h", "export/tiny.c", "selftest/tiny_replay.h", "selftest/tiny_selftest.c"}) {
    EXPECT_NE(again.read(file), "") << file;
    EXPECT_EQ(again.read(file), scratch_.read(std::string("d/") + file)) << file;
  }
  EXPECT_EQ(scratch_.read("d/model.json"), scratch_.read("a/model.json"));
}

TEST_F(DossierOfPlant, ScriptsOfTheSourceTreeLookAtItsPair) {
  scratch_.ok({"dossier", "a/model.json", "-q", "--source", NLO_SOURCE_DIR, "-o", "d"});
  const std::string index = scratch_.read("d/index.md");
  EXPECT_THAT(index, Not(HasSubstr(NLO_SOURCE_DIR)));
  for (const auto& [file, program] : {std::pair("eva.txt", "frama-c"), std::pair("misra.txt", "cppcheck")}) {
    const bool is_here = scratch_.run_program("/bin/sh", {"-c", std::string("command -v ") + program}).exit_code == 0;
    EXPECT_EQ(scratch_.read(std::string("d/") + file), is_here ? "ok      this:float\n" : "") << file;
    EXPECT_EQ(index.find(std::string("SKIPPED: no ") + program) == std::string::npos, is_here);
  }
  // A script that finds something ends the dossier.
  for (const char* script : {"eva.sh", "export_this.sh"})
    scratch_.write(std::string("tree/tests/proofs/") + script, "echo FAILED an alarm; exit 1\n");
  const std::string said = scratch_.refusal(1, {"dossier", "a/model.json", "-q", "--source", "tree", "-o", "e"});
  EXPECT_THAT(said, HasSubstr("eva.txt: FAILED an alarm"));
  EXPECT_FALSE(scratch_.has("e"));
}

TEST_F(DossierOfPlant, ItsPagesHaveTheNumbersOfItsFiles) {
  made("d");
  const std::string index = scratch_.read("d/index.md");
  const auto results = nlohmann::json::parse(scratch_.read("d/results.json"));
  ASSERT_EQ(results.size(), 2U) << "without noise, and with that of the training";
  for (const auto& result : results) {
    const double error = result["standard_error"]["over_test_sets"]["norm"].get<double>();
    EXPECT_GT(error, 0.0);
    EXPECT_THAT(index, HasSubstr(to_text(Spread{result["norm"].get<double>(), error})));
    for (const char* baseline : {"ekf", "constant", "ridge"})
      EXPECT_THAT(index, HasSubstr(std::string("| ") + result["noise"].get<std::string>() + " | " + baseline + " | "));
  }
  const auto identity = nlohmann::json::parse(scratch_.read("d/identity.json"));
  EXPECT_EQ(identity["model"]["sha256"], codegen::sha256(scratch_.read("a/model.json")));
  EXPECT_EQ(identity["experiment"]["sha256"], codegen::sha256(scratch_.read("d/experiment.toml")));
  EXPECT_EQ(identity["training_data"]["same"], true);
  // By another program than the build's.
  const Scratch other;
  const auto sums = other.run_program(
      "/bin/sh", {"-c", std::string("cd '") + NLO_SOURCE_DIR +
                            "' && find runtime codegen trainer -type f | LC_ALL=C sort | xargs sha256sum | sha256sum"});
  EXPECT_EQ(identity["nlo"]["sources_sha256"], sums.out.substr(0, 64));
  const auto model = nlohmann::json::parse(scratch_.read("a/model.json"));
  const auto domain = nlohmann::json::parse(scratch_.read("d/domain.json"));
  for (const char* member : {"output_min", "output_max", "latent_min", "latent_max"})
    EXPECT_EQ(domain[member], model[member]) << member;
  EXPECT_THAT(scratch_.read("d/replay.txt"), HasSubstr("tiny: 400 samples, 0 wrong, bits "));
  const auto bounds = nlohmann::json::parse(scratch_.read("d/bounds.json"));
  EXPECT_THAT(bounds.dump(), HasSubstr("\"evidence\":\"proven\""));
}

TEST_F(DossierOfPlant, TwoRunsGiveTheSameBytesAndTheSecondReplacesTheFirst) {
  made("one");
  made("two");
  const auto all = scratch_.contents();
  int files = 0;
  for (const auto& [path, text] : all)
    if (path.starts_with("one/")) {
      EXPECT_EQ(text, all.at("two/" + path.substr(4))) << path;
      ++files;
    }
  EXPECT_GT(files, 20);
  made("one");
  EXPECT_EQ(scratch_.contents(), all);
  std::string sums = scratch_.read("one/SHA256SUMS");
  std::istringstream lines(sums);
  for (std::string hash, file; lines >> hash >> file;)
    EXPECT_EQ(hash, codegen::sha256(scratch_.read("one/" + file))) << file;
}

TEST_F(DossierOfPlant, OneDigitOfTheModelOrOfItsDataHashIsSeen) {
  const std::string text = scratch_.read("a/model.json");
  const auto digit = text.find_first_of("1234567", text.find("\"weights\""));
  std::string other = text;
  ++other[digit];
  scratch_.write("other.json", other);
  made("d");
  made("e", "other.json");
  const std::string hash = codegen::sha256(other);
  EXPECT_NE(hash, codegen::sha256(text));
  for (const char* file : {"index.md", "identity.json", "SHA256SUMS"}) {
    EXPECT_THAT(scratch_.read(std::string("e/") + file), HasSubstr(hash)) << file;
    EXPECT_THAT(scratch_.read(std::string("d/") + file), Not(HasSubstr(hash))) << file;
  }
  EXPECT_NE(scratch_.read("d/export/tiny.c"), scratch_.read("e/export/tiny.c"));
  EXPECT_THAT(scratch_.read("d/index.md"), HasSubstr("computed again: the same"));

  const auto before = scratch_.contents();
  EXPECT_THAT(scratch_.ok({"dossier", "a/model.json", "--check", "-o", "d"}).out, HasSubstr("the same again"));
  const std::string differs = scratch_.refusal(1, {"dossier", "other.json", "--check", "-q", "-o", "d"});
  EXPECT_THAT(differs, HasSubstr("model.json (SHA-256 " + codegen::sha256(text) + " there, " + hash + " now)"));
  EXPECT_THAT(differs, HasSubstr("export/tiny.c"));
  EXPECT_THAT(differs, Not(HasSubstr("experiment.toml"))) << "which is the same";
  EXPECT_EQ(scratch_.contents(), before);

  const auto at = text.find("\"data_hash\": \"") + std::string("\"data_hash\": \"").size();
  std::string forged = text;
  forged[at] = text[at] == '0' ? '1' : '0';
  scratch_.write("forged.json", forged);
  made("f", "forged.json");
  EXPECT_THAT(scratch_.read("f/index.md"), HasSubstr("when computed again: other data"));
}

TEST_F(DossierOfPlant, WhatIsMissingOrInTheWayIsRefusedBeforeAnythingIsWritten) {
  scratch_.write("mine/thesis.tex", "years of work");
  scratch_.ok({"export", "a/model.json", "--target", "selftest", "-q", "-o", "selftest"});
  made("d");
  scratch_.write("d/notes.txt", "mine");
  const auto before = scratch_.contents();
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "dossier");
    return scratch_.refusal(2, words);
  };
  EXPECT_THAT(refusal({"none.json", "-o", "new"}), HasSubstr("none.json"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "mine"}), HasSubstr("mine: this folder was not made by nlo"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "selftest"}), HasSubstr("selftest: is another folder that nlo has made"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "d"}), HasSubstr("d/notes.txt: was added or changed"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "new", "--data", "no_*.csv"}), HasSubstr("no_*.csv"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "new", "--scalar", "half"}), HasSubstr("half"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "new", "--check"}), HasSubstr("no dossier to check"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "new", "--source", "mine"}), HasSubstr("mine: is not a source tree"));
  EXPECT_THAT(refusal({"a/model.json", "-o", "new", "--training-data", "mine"}), HasSubstr("not trained on logs"));
  EXPECT_EQ(scratch_.contents(), before);
  // A command that fails: a compiler that is not there compiles nothing.
  ::setenv("CC", "no-such-compiler", 1);
  const std::string said = scratch_.refusal(1, {"dossier", "a/model.json", "-q", "-o", "new"});
  ::unsetenv("CC");
  EXPECT_THAT(said, HasSubstr("export.txt"));
  EXPECT_THAT(said, HasSubstr("no-such-compiler"));
  EXPECT_EQ(scratch_.contents(), before);
}

TEST(DossierOfLogs, HasTheErrorsOnLogsThatAreGivenAndSaysWhereNoneAre) {
  if (std::string(NLO_CC).empty()) GTEST_SKIP() << "no C compiler here";
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyLogExperiment);
  scratch.write("logs/a.csv", tiny_log());
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.write("other/test one.csv", tiny_log(2.0));
  scratch.ok({"train", "tiny.toml", "-q", "--data", "logs", "-o", "a"});
  scratch.ok({"dossier", "a/model.json", "-q", "-o", "without"});
  EXPECT_FALSE(scratch.has("without/results.json") || scratch.has("without/results_on_logs.json"));
  EXPECT_THAT(scratch.read("without/index.md"), HasSubstr("no logs were given"));
  EXPECT_THAT(scratch.read("without/evidence.md"), HasSubstr("results_on_logs.json (not made)"));

  scratch.ok({"dossier", "a/model.json", "-q", "--data", "other/*.csv", "-o", "with"});
  const auto identity = nlohmann::json::parse(scratch.read("with/identity.json"));
  ASSERT_EQ(identity["logs"].size(), 1U);
  EXPECT_EQ(identity["logs"][0]["file"], "logs/test one.csv");
  EXPECT_EQ(identity["logs"][0]["sha256"], codegen::sha256(tiny_log(2.0)));
  // The logs' folder stands beside the model as `logs`, as the index says.
  const Scratch again;
  again.write("model.json", scratch.read("a/model.json"));
  again.write("logs/test one.csv", tiny_log(2.0));
  EXPECT_THAT(scratch.read("with/index.md"), HasSubstr("--data 'logs/test one.csv'"));
  EXPECT_THAT(scratch.read("with/index.md"), HasSubstr("as recorded; not computed again"));
  const auto with_training = [&](const char* folder) {
    scratch.ok({"dossier", "a/model.json", "-q", "--training-data", "logs", "-o", folder});
    return scratch.read(std::string(folder) + "/index.md");
  };
  EXPECT_THAT(with_training("same"), HasSubstr("computed again: the same"));
  scratch.write("logs/a.csv", tiny_log(0.1));
  EXPECT_THAT(with_training("changed"), HasSubstr("when computed again: other data"));
  const auto evaluated = again.ok({"evaluate", "model.json", "--json", "--data", "logs/test one.csv"});
  EXPECT_EQ(evaluated.out, scratch.read("with/results_on_logs.json"));
  EXPECT_THAT(evaluated.out, HasSubstr("\"norm\""));
}

TEST(DossierTable, NamesTestsThatThereAre) {
  const auto check = [](const EvidenceRow& row) {
    for (const std::string& evidence : row.tests) {
      const auto blank = evidence.find(' ');
      const std::string path = evidence.substr(0, blank);
      std::ifstream file(std::string(NLO_SOURCE_DIR) + "/" + path);
      ASSERT_TRUE(file) << path;
      if (blank == std::string::npos) continue;
      const std::string name = evidence.substr(blank + 1), text{std::istreambuf_iterator<char>(file), {}};
      const std::string test = name.substr(0, name.find('.')) + ", " + name.substr(name.find('.') + 1) + ")";
      EXPECT_THAT(text, HasSubstr(test)) << path;
    }
    EXPECT_FALSE(row.files.empty() && row.tests.empty() && row.integrator.empty()) << row.asks;
  };
  const DossierTable& table = dossier_table();
  std::ranges::for_each(table.requirements, check);
  EXPECT_EQ(table.standards.size(), 3U);
  for (const Standard& standard : table.standards) std::ranges::for_each(standard.rows, check);
}

TEST(DossierTable, RefusesAFileThatNoItemMakes) {
  const std::string text = "[[item]]\nfile = \"a.txt\"\n\n[[requirement]]\nasks = \"all\"\nfiles = [\"b.txt\"]\n";
  try {
    parse_dossier_table(text, "table.toml");
    FAIL() << "it was taken";
  } catch (const codegen::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("names b.txt, which no [[item]] makes"));
  }
}

}  // namespace
}  // namespace nlo::trainer
