// SPDX-License-Identifier: MIT
#include "trainer/reproduce/exam_table.h"

#include <fmt/format.h>

#include "trainer/app/report/html.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/reproduce/numbers_csv.h"
#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {
namespace {

Table table_of(const ExamTable& exam) {
  Table table{{exam.figure, "here", "published", "multiply-adds"}};
  for (const ExamRow& row : exam.rows)
    table.add_row({row.name, row.values.empty() ? "" : spread_text(row.values),
                   row.published ? significant(*row.published) : "",
                   row.multiply_adds ? fmt::format("{:.0f}", *row.multiply_adds) : ""});
  return table;
}

}  // namespace

ExamRow published(const std::string& name, double figure, std::optional<double> multiply_adds) {
  return {name, {}, figure, multiply_adds};
}

std::string exam_text(const ExamTable& exam) {
  return exam.title + "\n" + table_of(exam).to_text(2);
}

std::string exam_html(const ExamTable& exam) {
  return fmt::format("<h3>{}</h3>\n{}", escaped(exam.title), html_table(table_of(exam)));
}

std::string exams_csv(const std::vector<ExamTable>& exams) {
  NumbersCsv csv;
  for (const ExamTable& exam : exams)
    for (const ExamRow& row : exam.rows) {
      csv.add({exam.title, row.name, exam.figure, "test", "figure"}, row.published, row.values, {});
      if (row.multiply_adds)
        csv.add({exam.title, row.name, "multiply-adds", "sample", "cost"}, {}, {*row.multiply_adds}, {});
    }
  return csv.text();
}

}  // namespace nlo::trainer::reproduction
