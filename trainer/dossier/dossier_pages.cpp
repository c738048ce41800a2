// SPDX-License-Identifier: MIT
// The pages of a dossier for people. Every number is taken from the files beside them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "codegen/base/sha256.h"
#include "trainer/base/printable.h"
#include "trainer/dossier/make_dossier.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::ordered_json;

/// A cell of a table: a bar would end it, a line break the row.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : printable(text)) result += c == '|' ? "\\|" : c == '\n' ? " " : std::string(1, c);
  return result;
}

std::string row(const std::vector<std::string>& cells) {
  std::string text = "|";
  for (const std::string& each : cells) text += " " + cell(each) + " |";
  return text + "\n";
}

std::string heading(const std::vector<std::string>& cells) {
  std::string text = row(cells) + "|";
  for (std::size_t i = 0; i < cells.size(); ++i) text += "---|";
  return text + "\n";
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

const codegen::NamedText* find(const Dossier& dossier, std::string_view path) {
  const auto found = std::ranges::find(dossier.files, path, &codegen::NamedText::path);
  return found == dossier.files.end() ? nullptr : &*found;
}

std::string number_cell(const Json& result, const char* key) {
  if (!result.contains(key) || !result[key].is_number()) return "-";
  Spread spread{result[key].get<double>()};
  const Json over = result.value(Json::json_pointer("/standard_error/over_test_sets"), Json());
  if (over.is_object() && over.contains(key) && over[key].is_number()) spread.test_set_error = over[key].get<double>();
  return to_text(spread);
}

/// A row for each noise or log and each estimator.
std::string results_table(const Dossier& dossier, const char* file, const char* title) {
  const codegen::NamedText* text = find(dossier, file);
  if (text == nullptr) return "";
  const Json results = Json::parse(text->text);
  const auto settled = [](const Json& one) { return number_cell(one, "settled"); };
  std::string table = fmt::format("\n{}, norm of the error ([{}]({})):\n\n", title, file, file) +
                      heading({"noise", "estimator", "all", "settled"});
  for (const Json& result : results) {
    const std::string noise = result.value("noise", "");
    table += row({noise, "this observer", number_cell(result, "norm"), settled(result)});
    if (!result.contains("against")) continue;
    for (const auto& [name, other] : result["against"].items())
      table += row({noise, name, number_cell(other, "norm"), settled(other)});
  }
  return table;
}

std::string data_line(const Json& data) {
  if (data["hash"].is_null()) return "not recorded in the model";
  const std::string hash = data["hash"].get<std::string>();
  if (data["same"].is_null()) return hash + ", as recorded; not computed again";
  if (data["same"].get<bool>()) return hash + ", and computed again: the same";
  return fmt::format("{}, but {} when computed again: other data, or another build of nlo", hash,
                     data["hash_now"].get<std::string>());
}

std::string index_page(const DossierInput& input, const Dossier& dossier) {
  const Json identity = Json::parse(find(dossier, "identity.json")->text);
  std::string text = fmt::format("# Dossier of {}\n\n", printable(input.model.name)) + heading({"", ""});
  text += row({"model.json, SHA-256", identity["model"]["sha256"].get<std::string>()});
  if (identity.contains("experiment"))
    text += row({"experiment.toml, SHA-256", identity["experiment"]["sha256"].get<std::string>()});
  text += row({"training data, hash", data_line(identity["training_data"])});
  text += row({"nlo", fmt::format("{}, sources' SHA-256 {}", identity["nlo"]["version"].get<std::string>(),
                                  identity["nlo"]["sources_sha256"].get<std::string>())});
  text += row({"its program, SHA-256", identity["nlo"]["program_sha256"].get<std::string>()});
  text += row({"arithmetic", input.scalar});
  text += row({"golden replay", first_line(find(dossier, "replay.txt")->text)});
  text += results_table(dossier, "results.json", "On new runs of the plant");
  text += results_table(dossier, "results_on_logs.json", "On the logs that were given");
  text += "\nWhat is here, and how to make each again in this folder:\n\n" + heading({"file", "what", "again"});
  for (const DossierEntry& entry : dossier.entries)
    if (entry.refusal.empty()) text += row({fmt::format("[{0}]({0})", entry.item->file), entry.what, entry.again});
  text += "\nWhat is not made, and how to make it:\n\n" + heading({"file", "what", "why not", "how"});
  for (const DossierEntry& entry : dossier.entries)
    if (!entry.refusal.empty()) text += row({entry.item->file, entry.what, entry.refusal, entry.again});
  text +=
      "\n[evidence.md](evidence.md) says which file or test answers which requirement and which row of EASA's concept "
      "paper,\nISO 26262-6 and IEC 61508-3, and what is left to the integrator. `sha256sum -c SHA256SUMS` checks the "
      "files.\n";
  return text;
}

std::string evidence_cell(const EvidenceRow& asked, const Dossier& dossier) {
  std::vector<std::string> parts;
  for (const std::string& file : asked.files) {
    const bool made = find(dossier, file) != nullptr;
    parts.push_back(made ? fmt::format("[{0}]({0})", file) : file + " (not made)");
  }
  for (const std::string& test : asked.tests) parts.push_back("`" + test + "`");
  return parts.empty() ? "nothing" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string evidence_page(const DossierTable& table, const Dossier& dossier) {
  std::string text =
      "# Which evidence answers what?\n\n"
      "Files are those of this folder, tests those of nlo's source tree. This is a map for an assessor and claims no\n"
      "conformity: nlo is neither certified nor a qualified tool.\n\n## Requirements of the software\n\n" +
      heading({"requirement", "evidence"});
  for (const EvidenceRow& asked : table.requirements) text += row({asked.asks, evidence_cell(asked, dossier)});
  for (const Standard& standard : table.standards) {
    text += fmt::format("\n## {}\n\n", standard.name) + heading({"asks for", "here", "the integrator's"});
    for (const EvidenceRow& asked : standard.rows)
      text += row({asked.asks, evidence_cell(asked, dossier), asked.integrator});
  }
  return text;
}

}  // namespace

std::vector<codegen::NamedText> with_pages(const DossierInput& input, const DossierTable& table, Dossier dossier) {
  const std::string index = index_page(input, dossier), evidence = evidence_page(table, dossier);
  std::vector<codegen::NamedText> files = std::move(dossier.files);
  files.push_back({"index.md", index});
  files.push_back({"evidence.md", evidence});
  std::ranges::sort(files, {}, &codegen::NamedText::path);
  std::string sums;
  for (const codegen::NamedText& file : files) sums += fmt::format("{}  {}\n", codegen::sha256(file.text), file.path);
  files.push_back({"SHA256SUMS", sums});
  return files;
}

}  // namespace nlo::trainer
