// SPDX-License-Identifier: MIT
#include "trainer/prove/certificate.h"

#include <fmt/format.h>

#include <utility>

#include "trainer/judge/evaluation/json_numbers.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

/// To add a kind of rows, add a line here.
struct RowMaker {
  const char* name;
  CertificateRows (*rows)(const codegen::Model& model, const CertifyOptions& options);
};
constexpr RowMaker kRowMakers[] = {{"reachable latent states", latent_rows},
                                   {"contraction", contraction_rows},
                                   {"Lipschitz constants of T*", lipschitz_rows},
                                   {"largest estimates", estimate_rows},
                                   {"steady error", steady_rows},
                                   {"robustness to noise", robustness_rows},
                                   {"arithmetic of the exports", arithmetic_rows}};

std::vector<std::string> assumptions() {
  return {
      "The model's constants are the doubles in its file; the bounds compare with exact arithmetic on these constants.",
      "This program computes in IEEE double, rounded to nearest; each bound includes its rounding errors.",
      "Functions of the C library (tanh, exp) are within 4 units in the last place.",
      "The coefficients of a step in double have an error of at most 128 (1 + |lambda h|) units in the last place.",
      "The target computes in IEEE binary32, rounded to nearest, with the numbers that the export wrote."};
}

}  // namespace

const char* evidence_name(Evidence evidence) {
  return evidence == Evidence::kProven ? "proven" : "sampled";
}

CertificateRow absent_row(std::string id, std::string what, std::string why) {
  CertificateRow row;
  row.id = std::move(id);
  row.what = std::move(what);
  row.note = std::move(why);
  return row;
}

Certificate certify(const codegen::Model& model, const CertifyOptions& options) {
  Certificate certificate{model.name, std::string(codegen::structure_name(model)), {}, assumptions()};
  for (const RowMaker& maker : kRowMakers) {
    if (options.progress) options.progress(maker.name);
    for (CertificateRow& row : maker.rows(model, options)) certificate.rows.push_back(std::move(row));
  }
  return certificate;
}

std::string certificate_text(const Certificate& certificate) {
  constexpr std::size_t kOneTable = 400, kLongestNote = 300;
  Table table{{"", "evidence", "bound", "found", "bound / found"}};
  std::string notes;
  for (const CertificateRow& row : certificate.rows) {
    const std::string what = fmt::format("{}: {}", row.id, with_unit(row.what, row.unit));
    table.add_row(std::isnan(row.bound)
                      ? std::vector<std::string>{what, "-", "-", significant(row.found), "-"}
                      : std::vector<std::string>{what, evidence_name(row.evidence), significant(row.bound, 4),
                                                 significant(row.found, 4), significant(row.bound / row.found, 4)});
    std::string note = row.note;
    if (!row.where.empty()) note += fmt::format("{}largest value found {}", note.empty() ? "" : "; ", row.where);
    if (note.size() > kLongestNote) note = note.substr(0, kLongestNote) + "... (--json prints all of it)";
    if (!note.empty()) notes += fmt::format("  {}: {}\n", row.id, note);
  }
  std::string text = fmt::format("{}, structure {}: proven bounds, and the largest values that a search found\n\n{}\n",
                                 certificate.model, certificate.structure, table.to_text(2, kOneTable));
  text += notes + "Assumed:\n";
  for (const std::string& assumption : certificate.assumptions) text += "  " + assumption + "\n";
  return text;
}

std::string certificate_json(const Certificate& certificate) {
  Json json = {{"model", certificate.model},
               {"structure", certificate.structure},
               {"rows", Json::array()},
               {"assumptions", certificate.assumptions}};
  for (const CertificateRow& row : certificate.rows)
    json["rows"].push_back({{"id", row.id},
                            {"what", row.what},
                            {"unit", row.unit},
                            {"evidence", std::isnan(row.bound) ? Json(nullptr) : Json(evidence_name(row.evidence))},
                            {"bound", json_number(row.bound)},
                            {"found", json_number(row.found)},
                            {"where", row.where},
                            {"note", row.note}});
  return json_text(json) + "\n";
}

std::string broken_rows(const Certificate& certificate) {
  std::string text;
  for (const CertificateRow& row : certificate.rows)
    if (row.is_broken())
      text += fmt::format("{}the bound of {} is {}, but a search found {}{}", text.empty() ? "" : "; ", row.id,
                          row.bound, row.found, row.where.empty() ? "" : " " + row.where);
  return text;
}

}  // namespace nlo::trainer
