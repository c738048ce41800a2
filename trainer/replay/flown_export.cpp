// SPDX-License-Identifier: MIT
#include "trainer/replay/flown_export.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <vector>

#include "codegen/base/child.h"
#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/generated.h"
#include "codegen/targets/library.h"
#include "codegen/targets/registry.h"
#include "trainer/replay/flight_log.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
namespace fs = std::filesystem;

constexpr auto kCompiling = std::chrono::seconds(300), kFlying = std::chrono::seconds(600);

void write(const fs::path& folder, const std::string& name, const std::string& text) {
  fs::create_directories((folder / name).parent_path());
  codegen::write_file_atomically((folder / name).string(), text);
}

}  // namespace

FlownExport::FlownExport(const codegen::Model& model, const Flown& flown) : answers_(kAnswerEstimate + model.nx()) {
  const bool cpp = flown.target == "cpp";
  if (!cpp && flown.target != "c99")
    throw Error(
        fmt::format("--target {}: what flew is c99 (the bits of single and of the deterministic policy) or cpp "
                    "(the fast policy)",
                    flown.target));
  codegen::ExportOptions options;
  options.scalar = codegen::scalar_type(flown.scalar);
  options.weights = codegen::weight_type(flown.weights);
  if (!cpp) codegen::check_c99(model);
  const codegen::PreparedExport prepared(model, options, cpp ? flown.max_error : "");
  std::vector<codegen::NamedText> files = codegen::generated(codegen::export_target(flown.target), prepared);
  if (cpp)
    for (const std::string& header : codegen::runtime_headers(files.front().text))
      files.push_back({header, std::string(codegen::embedded_text(header))});

  const std::string& name = prepared.name();
  single_ = prepared.initialiser().scalar_bytes() == 4;
  settles_ = cpp ? model.nu() == 0 && codegen::linear_latent(model) != nullptr
                 : files.front().text.find(name + "_warm_start(") != std::string::npos;
  name_ = fmt::format("--target {} --scalar {}", flown.target, flown.scalar);
  const bool driven = model.nu() > 0;
  files.push_back({cpp ? "main.cpp" : "main.c",
                   codegen::filled(codegen::embedded_text("flight/replay.c.in"),
                                   {{"NAME", name},
                                    {"SCALAR", prepared.initialiser().scalar_name()},
                                    {"NM", std::to_string(model.measured())},
                                    {"NU", std::to_string(model.nu())},
                                    {"NX", std::to_string(model.nx())},
                                    {"AND_U", driven ? ", u" : ""},
                                    {"READ_U", model.inputs.empty() ? "" : ", u"},  // not those that act alone
                                    {"DRIVEN", driven ? "true" : ""},
                                    {"WARM_START", settles_ ? "true" : ""},
                                    {"CPP", cpp ? "true" : ""}})});
  folder_ = std::make_unique<codegen::TemporaryFolder>((fs::temp_directory_path() / "nlo-replay").string());
  for (const codegen::NamedText& file : files) write(folder_->name(), file.path, file.text);

  std::vector<std::string> command =
      codegen::words_of(flown.compiler.empty() ? cpp ? "c++ -O2" : "cc -O1" : flown.compiler);
  if (command.empty()) throw Error("--compiler has no word: name a compiler, with its flags");
  std::vector<std::string> rest = {"-std=c99", "main.c", name + ".c"};
  if (cpp) rest = {"-std=c++20", "-I.", "main.cpp"};
  command.insert(command.end(), rest.begin(), rest.end());
  command.insert(command.end(), {"-o", "flight"});
  const std::string failure = codegen::run_child(command, folder_->name(), kCompiling);
  if (!failure.empty())
    throw Error(
        fmt::format("{}: a flight is replayed by compiling what flew: install a {} compiler (gcc, clang), or "
                    "name yours with --compiler",
                    failure, cpp ? "C++20" : "C"));
}

Eigen::MatrixXd FlownExport::run(const Eigen::MatrixXd& given) const {
  const fs::path folder = folder_->name();
  const std::string_view bytes(reinterpret_cast<const char*>(given.data()),
                               static_cast<std::size_t>(given.size()) * sizeof(double));
  codegen::write_file_atomically((folder / "given.bin").string(), bytes);
  if (const std::string failure = codegen::run_child({"./flight"}, folder.string(), kFlying); !failure.empty())
    throw Error(failure);
  const std::string answered = codegen::read_file((folder / "answers.bin").string(), std::size_t{1} << 34);
  Eigen::MatrixXd answers(answers_, given.cols());
  if (answered.size() != static_cast<std::size_t>(answers.size()) * sizeof(double))
    throw Error("the replayed observer answered fewer steps than it was given");
  std::memcpy(answers.data(), answered.data(), answered.size());
  return answers;
}

}  // namespace nlo::trainer
