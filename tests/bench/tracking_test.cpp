// SPDX-License-Identifier: MIT
// Tracking of benchmark ratios, with made-up results: medians, which decreases are reported, and the exit codes on
// which scripts rely.
#include "bench/tracking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "bench/ratios.h"

namespace nlo::bench {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const Json kMachine{{"cpu", "Abacus 9"}, {"cores", 2}, {"system", "Linux x86_64"}};

Json run_of(const std::string& bench, const Json& ratios, const std::string& flags = "-O3") {
  return {
      {"bench", bench}, {"compiler", "GCC 12"}, {"flags", flags}, {"ratios", ratios}, {"targets", {{"a / b", 2.0}}}};
}

Json result_of(const Json& ratios) {
  return collect({run_of("some", ratios)}, kMachine);
}

/// A test with a directory of its own, which is removed at the end.
class Files : public ::testing::Test {
 protected:
  Files() : directory_(fs::path(::testing::TempDir()) / ("nlo_tracking_" + std::to_string(getpid()))) {
    fs::create_directories(directory_);
  }
  ~Files() override { fs::remove_all(directory_); }

  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
    return path(name);
  }
  std::string read(const std::string& name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  /// Runs the comparison and returns its exit code; its output is in the file "said".
  int compare(const std::string& arguments) const {
    const int status =
        std::system((std::string(NLO_COMPARE) + ' ' + arguments + " > " + path("said") + " 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  fs::path directory_;
};

TEST(Collect, UsesTheMedianOfTheRunsOfEachBenchmark) {
  const Json result = collect({run_of("some", {{"a / b", 1.0}, {"c / d", 5.0}}), run_of("other", {{"a / b", 7.0}}),
                               run_of("some", {{"a / b", 4.0}}), run_of("some", {{"a / b", 2.0}, {"c / d", 6.0}})},
                              kMachine);
  const Json& some = result.at("benches").at("some");
  EXPECT_EQ(some.at("runs"), 3);
  EXPECT_EQ(some.at("ratios").at("a / b"), (Json{{"median", 2.0}, {"lowest", 1.0}, {"highest", 4.0}, {"target", 2.0}}));
  EXPECT_EQ(some.at("ratios").at("c / d"), (Json{{"median", 5.5}, {"lowest", 5.0}, {"highest", 6.0}}));
  EXPECT_EQ(result.at("benches").at("other").at("ratios").at("a / b").at("median"), 7.0);
  EXPECT_EQ(result.at("machine"), kMachine);
}

TEST(Collect, RefusesRunsOfDifferentBuildsAndFilesThatAreNotRuns) {
  EXPECT_THROW(collect({run_of("some", {{"a", 1.0}}), run_of("some", {{"a", 1.0}}, "-O0")}, kMachine),
               std::runtime_error);
  EXPECT_THROW(collect({Json{{"ratios", {}}}}, kMachine), std::runtime_error);
  EXPECT_THROW(collect({Json::array()}, kMachine), std::runtime_error);
}

TEST(Compare, ReportsOnlyRatiosThatFellByMoreThanTheTolerance) {
  const Json before = result_of({{"a / b", 2.0}, {"c / d", 1.0}});
  EXPECT_EQ(compare(before, before, 0.1).fallen, 0);
  EXPECT_EQ(compare(before, result_of({{"a / b", 1.81}, {"c / d", 9.0}}), 0.1).fallen, 0);
  const Comparison fell = compare(before, result_of({{"a / b", 1.79}, {"c / d", 1.0}}), 0.1);
  EXPECT_EQ(fell.fallen, 1);
  EXPECT_THAT(fell.table, AllOf(HasSubstr("FELL"), HasSubstr("2.000"), HasSubstr("1.790"), HasSubstr("-10.5 %")));
  EXPECT_EQ(compare(before, result_of({{"a / b", 1.79}, {"c / d", 1.0}}), 0.2).fallen, 0);
}

TEST(Compare, ListsMissingAndNewRatios) {
  const Comparison result = compare(result_of({{"a / b", 2.0}}), result_of({{"c / d", 1.0}}), 0.1);
  EXPECT_EQ(result.missing, 1);
  EXPECT_EQ(result.fallen, 0);
  EXPECT_THAT(result.table, AllOf(HasSubstr("MISSING"), HasSubstr("new ")));
  const Json empty = collect({}, kMachine);
  EXPECT_EQ(compare(result_of({{"a / b", 2.0}}), empty, 0.1).missing, 1) << "a whole benchmark is gone";
}

TEST(Compare, NamesChangesOfMachineAndBuild) {
  Json now = result_of({{"a / b", 2.0}});
  EXPECT_THAT(compare(now, now, 0.1).differences, "");
  const Json before = now;
  now["machine"]["cpu"] = "Slide rule";
  now["benches"]["some"]["flags"] = "-O0";
  EXPECT_THAT(compare(before, now, 0.1).differences,
              AllOf(HasSubstr("Abacus 9 before, Slide rule now"), HasSubstr("some, flags: -O3 before, -O0 now")));
}

TEST(Markdown, HasARowPerRatioThatSaysWhetherItMeetsItsTarget) {
  EXPECT_THAT(markdown(result_of({{"a / b", 2.0}, {"c | d", 3.25}})),
              AllOf(HasSubstr("Abacus 9, 2 cores"), HasSubstr("| a / b | 2.00 (2.00 to 2.00) | 2.00, met |"),
                    HasSubstr("| c \\| d | 3.25")));
  EXPECT_THAT(markdown(result_of({{"a / b", 1.99}})), HasSubstr("**not met**"));
}

TEST_F(Files, ExitCodeIsOneForADecreaseAndTwoForWrongUsage) {
  const std::string before = write("before.json", result_of({{"a / b", 2.0}}).dump());
  const std::string good = write("good.json", result_of({{"a / b", 2.1}}).dump());
  const std::string bad = write("bad.json", result_of({{"a / b", 1.0}}).dump());
  EXPECT_EQ(compare(before + ' ' + good), 0) << read("said");
  EXPECT_EQ(compare(before + ' ' + bad), 1) << read("said");
  EXPECT_EQ(compare(before + ' ' + bad + " --tolerance 0.6"), 0) << read("said");
  EXPECT_EQ(compare(before), 2);
  EXPECT_EQ(compare(before + ' ' + path("none.json")), 2);
  EXPECT_THAT(read("said"), HasSubstr("none.json"));
  EXPECT_EQ(compare(before + ' ' + write("broken.json", "{\"machine\":")), 2);
  EXPECT_EQ(compare(before + ' ' + write("other.json", "{\"machine\": {}}")), 2);
  EXPECT_EQ(compare(before + ' ' + good + " --tolerance 10%"), 2);
}

TEST_F(Files, CollectsResultsOfABenchmarkAndWritesTheirTableIntoADocument) {
  const std::string file = path("run.json");
  std::string arguments[] = {"bench", "--json", file, "7"};
  char* argv[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(), arguments[3].data(), nullptr};
  int argc = 4;
  Ratios ratios("some", argc, argv);
  EXPECT_EQ(argc, 2);
  EXPECT_STREQ(argv[1], "7");
  ratios.add("a / b", 2.5, 2.0);
  ASSERT_EQ(ratios.write(), 0);
  ASSERT_EQ(compare("--collect " + path("result.json") + ' ' + file), 0) << read("said");
  const std::string document = write("doc.md", "before\n<!-- table -->\nold\n<!-- end of table -->\nafter\n");
  ASSERT_EQ(compare("--write " + path("result.json") + ' ' + document), 0) << read("said");
  EXPECT_THAT(read("doc.md"), AllOf(HasSubstr("before\n"), HasSubstr("after\n"), Not(HasSubstr("old")),
                                    HasSubstr("| a / b | 2.50 (2.50 to 2.50) | 2.00, met |"), HasSubstr("`-O9`")));
  EXPECT_EQ(compare("--write " + path("result.json") + ' ' + write("plain.md", "no marks\n")), 2);
}

TEST_F(Files, RefusesToWriteARatioThatIsNotFinite) {
  std::string arguments[] = {"bench", "--json", path("run.json")};
  char* argv[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(), nullptr};
  int argc = 3;
  Ratios ratios("some", argc, argv);
  ratios.add("a / b", 0.0);
  EXPECT_EQ(ratios.write(), 1);
  EXPECT_FALSE(fs::exists(path("run.json")));
}

}  // namespace
}  // namespace nlo::bench
