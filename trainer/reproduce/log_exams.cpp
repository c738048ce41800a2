// SPDX-License-Identifier: MIT
// Exams on logs of others: inclination from an inertial sensor (BROAD), the state of charge of a cell (LG HG2).
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/targets/cpp_cost.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/exam_table.h"

namespace nlo::trainer::reproduction {
namespace {

/// A model of logs and simpler estimators on each test log.
class LogExam {
 public:
  LogExam(const Workbench& bench, std::string_view experiment, std::string_view logs)
      : bench_(bench), experiment_(experiment), schema_(resolve_columns(*config().log)) {
    splits_ = load_log_splits(*config().log, bench.data + "/" + std::string(logs));
    for (int seed = 0; seed < bench.seeds; ++seed)
      evaluations_.push_back(
          evaluate_on_logs(bench.model(experiment, seed), splits_.test, schema_, &splits_.train, {}, config().seed));
  }

  ExamRow observer(const std::string& name, std::size_t file, double factor = 1.0) const {
    ExamRow row{name};
    for (const LogEvaluation& evaluation : evaluations_)
      row.values.push_back(factor * error_of(evaluation.entries.front(), file));
    row.multiply_adds =
        static_cast<double>(codegen::cpp_cost(codegen::PreparedExport(bench_.model(experiment_, 0))).multiply_adds());
    return row;
  }

  ExamRow baseline(const std::string& name, std::string_view estimator, std::size_t file, double factor = 1.0) const {
    const std::vector<LogEntry>& entries = evaluations_.front().entries;
    const auto entry = std::ranges::find(entries, estimator, &LogEntry::estimator);
    if (entry == entries.end()) throw codegen::Error(fmt::format("{} does not apply to these logs", estimator));
    return {name, {factor * error_of(*entry, file)}, {}, entry->cost.operations / 2.0};
  }

 private:
  const Experiment& config() const { return bench_.experiment(experiment_); }

  /// Error of the last quantity; a direction stands behind its components.
  static double error_of(const LogEntry& entry, std::size_t file) {
    return entry.metrics.files.at(file).states.back().rmse.front();
  }

  const Workbench& bench_;
  std::string_view experiment_;
  LogSchema schema_;
  LogSplits splits_;
  std::vector<LogEvaluation> evaluations_;
};

}  // namespace

Section inclination(const Workbench& bench) {
  const LogExam vectors(bench, "inclination", "broad");
  const LogExam one(bench, kOneVector, "broad");
  Section section;
  section.exams = {
      {"Inclination, trial 24",
       "angle [deg]",
       {vectors.observer("nlo, three vectors", 0), one.observer("complementary filter, one vector", 0),
        vectors.baseline("ridge of products", "static_ridge", 0), vectors.baseline("constant", "constant", 0),
        published("VQF, seven trials", 0.91), published("RIANN, seven trials", 1.38, 365'000.0)}}};
  section.csv = exams_csv(section.exams);
  section.seen =
      "Eight undisturbed trials train, a disturbed one tests. One sensor made all of them. Published figures are of "
      "this trial and six that are not here; VQF is tuned on other data.";
  return section;
}

Section charge(const Workbench& bench) {
  struct Temperature {
    const char* name;
    double lstm;  // Wong et al.
  };
  constexpr Temperature kTemperatures[] = {{"0 degC", 2.27}, {"10 degC", 2.12}, {"25 degC", 1.57}};
  constexpr double kPercent = 100.0, kLstm = 790'000.0;  // 4 x 256 x (3 + 256) + 4 x 256 x 512
  const LogExam exam(bench, kCharge, "battery");
  Section section;
  for (std::size_t i = 0; i < std::size(kTemperatures); ++i)
    section.exams.push_back(
        {fmt::format("State of charge, {}", kTemperatures[i].name),
         "RMSE [%]",
         {exam.observer("nlo", i, kPercent), exam.baseline("ridge of products", "static_ridge", i, kPercent),
          exam.baseline("constant", "constant", i, kPercent),
          published("LSTM, 2 x 256", kTemperatures[i].lstm, kLstm)}});
  section.csv = exams_csv(section.exams);
  section.seen =
      "Five Mixed cycles at each temperature train, Mixed7 tests. Of Wong's split UDDS, LA92 and US06 are not here, "
      "and the label is the cycler's charge, not 0 at each log's own end. What leaks: one cell made all logs, and each "
      "of "
      "them starts full, so counting from full would be nearly exact; no observer is told that.";
  return section;
}

}  // namespace nlo::trainer::reproduction
