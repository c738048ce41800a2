// SPDX-License-Identifier: MIT
#include "trainer/sweep/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <set>

#include "codegen/base/error.h"
#include "trainer/base/shell_word.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::IsSubsetOf;
using testing::SizeIs;

std::vector<SweepJob> jobs(const std::string& text) {
  return jobs_of(parse_sweep_plan("experiment = \"tiny.toml\"\n" + text, "plan.toml"));
}

std::vector<std::string> names(const std::string& text) {
  std::vector<std::string> all;
  for (const SweepJob& job : jobs(text)) all.push_back(job.name);
  return all;
}

/// What a shell makes of `word`.
std::string by_the_shell(const std::string& word) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(("printf %s " + word).c_str(), "r"), ::pclose);
  std::string text;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) text += static_cast<char>(c);
  return text;
}

TEST(SweepJobs, KeepTheirFoldersWhenThePlanGrows) {
  const auto before = names("seeds = [1, 2]\n[grid]\ninverse_map.hidden = [[8], [16, 16]]\ntraining.steps = [10]\n");
  const auto after = names(
      "seeds = [3, 2, 1]\n[grid]\ntraining.steps = [10, 20]\ninverse_map.hidden = [[16, 16], [4], [8]]\n"
      "[[point]]\ntraining.steps = 7\n");
  EXPECT_THAT(before, SizeIs(4));
  EXPECT_THAT(after, SizeIs(3 * 7));
  EXPECT_THAT(before, IsSubsetOf(after));
}

// Folders of yesterday are found by the program of tomorrow: this name must not change.
TEST(SweepJobs, HaveNamesThatStayForever) {
  EXPECT_EQ(names("seeds = [1]\n[grid]\ninverse_map.hidden = [[16, 16]]\n").front(), "hidden-16-16_seed-1_a3a612fb86");
}

TEST(SweepJobs, HaveNamesOfTheirOwnThatAnyFileSystemTakes) {
  const std::string text = "seeds = [1, 2]\n[grid]\nplant.model = [\"a/../b\", \"a..b\", \"a b\", \"-\", \"\", \"" +
                           std::string(300, 'x') + "\", \"" + std::string(301, 'x') + "\"]\nx = [-1, 1, [1], [[1]]]\n";
  const auto all = names(text);
  EXPECT_THAT(std::set<std::string>(all.begin(), all.end()), SizeIs(2 * 7 * 4));
  for (const std::string& name : all) {
    EXPECT_LT(name.size(), 120U);
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.-"), std::string::npos) << name;
  }
}

TEST(SweepShards, HaveEveryJobOnce) {
  for (const std::size_t count : {1U, 2U, 3U, 7U, 20U}) {
    std::vector<int> taken(17, 0);
    for (std::size_t index = 0; index < count; ++index) {
      const Shard shard = parse_shard(std::to_string(index) + "/" + std::to_string(count));
      std::size_t own = 0;
      for (std::size_t j = 0; j < taken.size(); ++j)
        if (shard.has(j)) ++taken[j], ++own;
      EXPECT_LE(own, taken.size() / count + 1) << "shards are of one size, to a job";
    }
    EXPECT_THAT(taken, testing::Each(1)) << count << " shards";
  }
}

TEST(SweepShards, RefuseWhatIsNoPart) {
  for (const char* text :
       {"", "3", "4/4", "-1/4", "0/0", "1/", "/4", "1/4x", "a/b", "99999999999999999999/4", "0 /4"}) {
    try {
      parse_shard(text);
      ADD_FAILURE() << text;
    } catch (const codegen::Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("--shard 0/4 for the first of four"));
    }
  }
}

TEST(SweepLines, ReachTheProgramAsTheyAre) {
  for (const std::string word : {"plain", "", "a b", "a'b", "$(false) `x` \"y\" \\ ; & | < > * ? ~ # !", "ü", "a\nb"})
    EXPECT_EQ(by_the_shell(shell_word(word)), word);
  EXPECT_EQ(shell_word("training.steps=3"), "training.steps=3") << "no quotes where none are needed";
}

TEST(SweepLines, AreTheWholeCommand) {
  const SweepJob job = jobs("seeds = [5]\n[grid]\na.b = [\"it's\"]\n").front();
  EXPECT_EQ(job_line(job, {"x y.toml", "logs", "runs/p", 1}),
            "nlo train 'x y.toml' --data logs --set 'a.b=\"it'\\''s\"' --seed 5 --threads 1 -o runs/p/" + job.name +
                " --resume -q");
  EXPECT_THROW(job_line(job, {"x\ny.toml", "", "runs/p", {}}), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
