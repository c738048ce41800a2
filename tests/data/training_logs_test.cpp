// SPDX-License-Identifier: MIT
#include "trainer/data/training_logs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/data/data_testing.h"
#include "trainer/data/log_dataset.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Rows `from` to `to` of a noisy wave; at rest (equal rows) before row 100.
std::string rows(unsigned seed, int from, int to, double clock_s = 0.0, double scale = 1.0) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string text = "time,a,b\n";
  for (int k = 0; k < to; ++k) {
    const double a = k < 100 ? 0.0 : scale * (std::sin(0.05 * k) + noise(engine));
    char row[80];
    std::snprintf(row, sizeof row, "%.3f,%.7g,%.7g\n", clock_s + 0.01 * k, a, k < 100 ? 0.0 : std::cos(0.05 * k));
    if (k >= from) text += row;
  }
  return text;
}

class TrainingLogsTest : public ::testing::Test {
 protected:
  TrainingLogsTest() {
    config_.columns = {column("time", ColumnRole::kTime), column("a", ColumnRole::kOutput, {.unit = "m"}),
                       column("b", ColumnRole::kState)};
    config_.train_files = {"train*.csv"};
    config_.test_files = {"test.csv"};
    scratch_.write("train1.csv", rows(1, 0, 900));
    scratch_.write("train2.csv", rows(2, 0, 900));
  }
  std::vector<std::string> notes_with(const std::string& test, const std::vector<std::string>& mirrored = {}) {
    scratch_.write("test.csv", test);
    return load_log_splits(config_, scratch_.path(), mirrored).report.notes;
  }

  ScratchDirectory scratch_;
  LogConfig config_;
};

TEST_F(TrainingLogsTest, NotesATestLogThatIsAPartOfATrainingLog) {
  EXPECT_THAT(notes_with(rows(3, 0, 900)), IsEmpty());  // control: the same rest at the start, but another run
  EXPECT_THAT(notes_with(rows(1, 400, 600, 77.0)),
              ElementsAre(AllOf(HasSubstr("test.csv: 100 % of its moving rows are also in the training log train1.csv"),
                                HasSubstr("remove it from test_files"))));
}

TEST_F(TrainingLogsTest, NotesOutputsBeyondTheTrainingRange) {
  EXPECT_THAT(notes_with(rows(3, 0, 900, 0.0, 1.5)),
              ElementsAre(AllOf(HasSubstr("test.csv: output \"a\" leaves its training range, -1."),
                                HasSubstr(" m, by up to 0.5"), HasSubstr("% of the samples"))));
  EXPECT_THAT(notes_with(rows(3, 0, 900, 0.0, 1.03)), IsEmpty());
}

TEST_F(TrainingLogsTest, TrainingRangeIncludesMirrorImages) {
  config_.train_files = {"half.csv"};
  scratch_.write("half.csv", "time,a,b\n0,0,0\n0.01,0.5,1\n0.02,0.9,0\n0.03,1,0.4\n");
  const std::string negative = "time,a,b\n0,0,0\n0.01,-0.5,1\n0.02,-0.9,0\n0.03,-1,0.4\n";
  EXPECT_THAT(notes_with(negative), ElementsAre(HasSubstr("leaves its training range, 0 to 1 m, by up to 1 m")));
  EXPECT_THAT(notes_with(negative, {"a", "b"}), IsEmpty());
  EXPECT_THAT(notes_with(negative, std::vector<std::string>{"b"}),
              ElementsAre(HasSubstr("leaves its training range, 0 to 1 m")));
}

TEST_F(TrainingLogsTest, ModelRecordsTheLogsThatTrainedIt) {
  scratch_.write("test.csv", rows(3, 0, 900));
  const LogSplits splits = load_log_splits(config_, scratch_.path());
  const TrainingLogs remembered = parse_training_logs(to_text(splits.remembered));
  ASSERT_EQ(remembered.logs.size(), 2u);
  EXPECT_EQ(remembered.logs[1].name, "train2.csv");
  EXPECT_EQ(remembered.logs[1].rows, 900);
  EXPECT_EQ(remembered.outputs[0].low, splits.remembered.outputs[0].low);

  const auto notes_on = [&](const std::string& csv) {
    scratch_.write("judged.csv", csv);
    LogReport report;
    load_logs(config_, scratch_.path(), {"judged.csv"}, &report);
    note_rows_of_training(remembered, report.contents, report.notes);
    return report.notes;
  };
  EXPECT_THAT(notes_on(rows(3, 0, 900)), IsEmpty());
  EXPECT_THAT(notes_on(rows(2, 0, 900)), ElementsAre(AllOf(HasSubstr("judged.csv: it contains"),
                                                           HasSubstr("about 100 % of the training log train2.csv"))));
  EXPECT_THAT(notes_on(rows(2, 300, 800, 5.0)), ElementsAre(HasSubstr("of the training log train2.csv")));
}

TEST_F(TrainingLogsTest, ProvenanceIsPlainTextForAnyFileName) {
  TrainingLogs logs;
  logs.logs.push_back({"run 1, a.csv", 12, {}});
  logs.outputs.push_back({"a", -0.5, 1e-3});
  const TrainingLogs read = parse_training_logs(to_text(logs));
  EXPECT_EQ(read.logs[0].name, "run 1, a.csv");
  EXPECT_EQ(read.logs[0].rows, 12);
  EXPECT_EQ(read.outputs[0].high, 1e-3);
  EXPECT_THAT(thrown_message([] { parse_training_logs("log x  a.csv"); }), HasSubstr("\"x\" is not a number"));
  EXPECT_THAT(thrown_message([] { parse_training_logs("lag 1  a.csv"); }), HasSubstr("a line begins with \"lag\""));
}

TEST(LogContent, IgnoresWindowsAtRest) {
  LogFile log;
  log.time_s = Eigen::VectorXd::LinSpaced(200, 0.0, 199.0);
  log.columns["a"] = Eigen::VectorXd::Zero(200);
  EXPECT_TRUE(content_of(log, {"a"}).windows.empty());
  log.columns["a"].tail(100).setLinSpaced(100, 1.0, 2.0);
  // 100 changes, in rows 100 to 199. Windows with at least 16 of them after their first row end at rows 115 to 199.
  EXPECT_EQ(content_of(log, {"a"}).windows.size(), 85u);
}

}  // namespace
}  // namespace nlo::trainer
