// SPDX-License-Identifier: MIT
#include "trainer/dossier/make_dossier.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "codegen/base/child.h"
#include "codegen/base/error.h"
#include "codegen/base/sha256.h"
#include "codegen/base/temporary.h"
#include "trainer/base/noise.h"
#include "trainer/base/version.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Folders of the logs by the names that they have in commands: logs, logs_2, ...
std::vector<std::pair<std::string, fs::path>> log_folders(const std::vector<std::string>& logs) {
  std::vector<std::pair<std::string, fs::path>> folders;
  for (const std::string& log : logs) {
    const fs::path folder = fs::path(log).parent_path();
    if (std::ranges::find(folders, folder, &std::pair<std::string, fs::path>::second) != folders.end()) continue;
    folders.emplace_back(folders.empty() ? "logs" : fmt::format("logs_{}", folders.size() + 1), folder);
  }
  return folders;
}

std::vector<std::string> log_names(const std::vector<std::string>& logs) {
  const auto folders = log_folders(logs);
  std::vector<std::string> names;
  for (const std::string& log : logs) {
    const fs::path path = log;
    const auto folder = std::ranges::find(folders, path.parent_path(), &std::pair<std::string, fs::path>::second);
    names.push_back(folder->first + "/" + path.filename().string());
  }
  return names;
}

std::string fact(const codegen::Model& model, std::string_view name) {
  for (const auto& [key, value] : model.provenance)
    if (key == name) return value;
  return "";
}

std::string identity(const DossierInput& input, const std::string&) {
  Json json;
  json["model"] = {{"name", input.model.name}, {"sha256", codegen::sha256(input.model_text)}};
  json["nlo"] = {{"version", kVersion},
                 {"sources_sha256", input.sources},
                 {"program_sha256", codegen::sha256(codegen::read_file(input.program))}};
  if (input.experiment != nullptr) json["experiment"] = {{"sha256", codegen::sha256(fact(input.model, "config"))}};
  const std::string recorded = fact(input.model, "data_hash");
  Json& data = json["training_data"];
  data["hash"] = recorded.empty() ? Json() : Json(recorded);
  data["hash_now"] = input.data_hash.empty() ? Json() : Json(input.data_hash);
  data["same"] = recorded.empty() || input.data_hash.empty() ? Json() : Json(recorded == input.data_hash);
  for (const auto& [key, value] : input.model.provenance)
    if (key != "config") json["provenance"][key] = value;
  json["logs"] = Json::array();
  const std::vector<std::string> names = log_names(input.logs);
  for (std::size_t i = 0; i < names.size(); ++i)
    json["logs"].push_back({{"file", names[i]}, {"sha256", codegen::sha256(codegen::read_file(input.logs[i]))}});
  return json.dump(2) + "\n";
}

/// The members of the model's file that say where it may be used, number for number.
std::string domain(const DossierInput& input, const std::string&) {
  constexpr std::array kMembers = {"structure",  "outputs",    "inputs",     "states",    "sample_period_s",
                                   "may_fail",   "output_min", "output_max", "input_min", "input_max",
                                   "latent_min", "latent_max", "saturation", "monitor"};
  const Json model = Json::parse(input.model_text);
  Json json;
  for (const char* member : kMembers)
    if (model.contains(member)) json[member] = model[member];
  return json.dump(1) + "\n";
}

/// All files below `folder` but what the running of commands has left there; links are not followed.
std::vector<codegen::NamedText> files_in(const fs::path& folder) {
  std::vector<codegen::NamedText> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (entry.is_symlink() || !entry.is_regular_file() || name == "log.txt") continue;
    files.push_back({name, codegen::read_file(entry.path().string())});
  }
  std::ranges::sort(files, {}, &codegen::NamedText::path);
  return files;
}

/// What the program of selftest/ says of the golden replay, compiled here: "NAME: 400 samples, 0 wrong, bits 7c1d4e02".
/// Throws codegen::Error where an answer is wrong.
std::string golden_replay(const DossierInput& input, const std::string& folder) {
  constexpr auto kPatience = std::chrono::minutes(5);
  const codegen::TemporaryFolder built((fs::temp_directory_path() / "nlo-dossier").string());
  const char* chosen = std::getenv("CC");
  std::vector<std::string> words = codegen::words_of(chosen != nullptr ? chosen : "");
  if (words.empty()) words = {"cc"};
  words.insert(words.end(), {"-std=c99", "-o", built.name() + "/replay"});
  for (const codegen::NamedText& file : files_in(fs::path(folder) / "selftest"))
    if (file.path.ends_with(".c")) words.push_back(folder + "/selftest/" + file.path);
  std::string failure = codegen::run_child(words, built.name(), kPatience);
  if (failure.empty()) failure = codegen::end_of_child({"./replay"}, built.name(), kPatience, "said.txt").failure;
  if (!failure.empty()) throw codegen::Error(fmt::format("replay.txt: {}; nothing is written", failure));
  const std::string said = codegen::read_file(built.name() + "/said.txt");
  const std::string line = said.substr(0, said.find('\n'));
  if (line.find(" 0 wrong,") == std::string::npos)
    throw codegen::Error(
        fmt::format("replay.txt: the golden replay of {} failed here: {}; nothing is written", input.model.name, line));
  return line + "\n";
}

using OwnFile = std::string (*)(const DossierInput& input, const std::string& folder);

/// Files that no command makes, by their names.
const std::map<std::string, OwnFile>& own_files() {
  static const std::map<std::string, OwnFile> kFiles = {
      {"model.json", [](const DossierInput& input, const std::string&) { return input.model_text; }},
      {"experiment.toml", [](const DossierInput& input, const std::string&) { return fact(input.model, "config"); }},
      {"identity.json", identity},
      {"domain.json", domain},
      {"replay.txt", golden_replay},
  };
  return kFiles;
}

/// Why an item cannot be made of this input; empty: it can.
std::string missing(const DossierItem& item, const DossierInput& input) {
  if (item.needs == "tree" && input.tree.empty()) return "no source tree of nlo was given";
  if (item.needs == "judgement") return "takes what nlo dossier does not have, or a judgement";
  if (item.needs == "training" && input.experiment == nullptr) return "the model does not say what trained it";
  if (item.needs == "plant" && (input.experiment == nullptr || !input.experiment->plant))
    return "the model was not trained on a plant";
  if (item.needs == "logs" && input.logs.empty()) return "no logs were given";
  return "";
}

/// `text` with what stands in braces replaced by what it is of this model.
std::string filled(std::string text, const DossierInput& input) {
  const std::array<std::pair<std::string, std::string>, 4> values = {{{"{name}", input.model.name},
                                                                      {"{scalar}", input.scalar},
                                                                      {"{seed}", fact(input.model, "seed")},
                                                                      {"{steps}", fact(input.model, "steps")}}};
  for (const auto& [key, value] : values)
    for (auto at = text.find(key); at != std::string::npos; at = text.find(key, at + value.size()))
      text.replace(at, key.size(), value);
  return text;
}

/// The words of a command, {noises} and {logs} replaced by several.
std::vector<std::string> filled_words(const std::string& command, const DossierInput& input) {
  std::vector<std::string> noises = {"--noise", "none"};
  if (input.experiment != nullptr)
    for (const NoiseConfig& noise : input.experiment->training.all_noise().parts)
      if (!noise.none()) noises.insert(noises.end(), {"--noise", format_noise(noise)});
  const std::map<std::string, std::vector<std::string>> lists = {{"{noises}", noises},
                                                                 {"{logs}", log_names(input.logs)}};
  std::vector<std::string> words;
  for (const std::string& word : codegen::words_of(command)) {
    if (const auto list = lists.find(word); list != lists.end())
      words.insert(words.end(), list->second.begin(), list->second.end());
    else
      words.push_back(filled(word, input));
  }
  return words;
}

/// Words as a shell takes them.
std::string shell_text(const std::vector<std::string>& words) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  std::string text;
  for (const std::string& word : words) {
    std::string quoted = word;
    if (word.empty() || word.find_first_not_of(kPlain) != std::string::npos) {
      quoted = "'";
      for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
      quoted += "'";
    }
    text += (text.empty() ? "" : " ") + quoted;
  }
  return text;
}

/// Runs its command or script in `folder`. Throws codegen::Error.
void run(DossierEntry& entry, const DossierInput& input, const std::string& folder,
         const std::function<void(const std::string& command)>& before) {
  constexpr auto kPatience = std::chrono::hours(24);
  constexpr int kRefused = 2, kSkipped = 77;
  const DossierItem& item = *entry.item;
  const bool of_nlo = item.script.empty();
  std::vector<std::string> words = filled_words(of_nlo ? item.command : item.script, input);
  const std::string command = (of_nlo ? "nlo " : "") + shell_text(words);
  entry.again = "`" + command + "`";
  before(command);
  if (of_nlo)
    words.insert(words.begin(), input.program);
  else
    words.insert(words.begin(), {"env", "NLO=" + input.program});
  const codegen::ChildEnd end = codegen::end_of_child(words, folder, kPatience, item.file);
  if (end.failure.empty()) return;
  const fs::path printed = fs::path(folder) / item.file;
  std::string said = of_nlo ? end.failure : codegen::read_file(printed.string());
  said = said.substr(0, said.find_last_not_of('\n') + 1);
  const bool is_refusal = of_nlo ? item.refusable && end.exit_code == kRefused : end.exit_code == kSkipped;
  if (!is_refusal)
    throw codegen::Error(fmt::format("{}: {}, which {} should make; nothing is written", item.file, said, entry.again));
  fs::remove(printed);
  const std::string mark = "error: ";
  const auto at = said.find(mark);
  entry.refusal = at == std::string::npos ? said : said.substr(at + mark.size());
}

}  // namespace

Dossier make_dossier(const DossierInput& input, const DossierTable& table,
                     const std::function<void(const std::string& command)>& before) {
  const codegen::TemporaryFolder folder((fs::temp_directory_path() / "nlo-dossier").string());
  for (const auto& [name, path] : log_folders(input.logs))
    fs::create_directory_symlink(path, fs::path(folder.name()) / name);
  if (!input.tree.empty()) fs::create_directory_symlink(input.tree, fs::path(folder.name()) / "nlo");
  Dossier dossier;
  for (const DossierItem& item : table.items) {
    dossier.entries.push_back({&item, filled(item.what, input), filled(item.again, input), missing(item, input)});
    DossierEntry& entry = dossier.entries.back();
    if (!entry.refusal.empty()) continue;
    if (const auto own = own_files().find(item.file); own != own_files().end()) {
      codegen::write_file_atomically(folder.name() + "/" + item.file, own->second(input, folder.name()));
      continue;
    }
    run(entry, input, folder.name(), before);
  }
  dossier.files = files_in(folder.name());
  return dossier;
}

}  // namespace nlo::trainer
