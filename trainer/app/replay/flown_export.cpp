// SPDX-License-Identifier: MIT
#include "trainer/app/replay/flown_export.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "codegen/base/child.h"
#include "codegen/base/embedded_text.h"
#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/library.h"
#include "codegen/targets/observers_in.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/targets/target_registry.h"
#include "trainer/app/replay/flight_log.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
namespace fs = std::filesystem;

constexpr auto kCompiling = std::chrono::seconds(300), kFlying = std::chrono::seconds(600);

void write(const fs::path& folder, const std::string& name, const std::string& text) {
  fs::create_directories((folder / name).parent_path());
  codegen::write_file_atomically((folder / name).string(), text);
}

codegen::PreparedExport prepared_of(const codegen::Model& model, const Flown& flown) {
  const bool cpp = flown.target == "cpp";
  if (!cpp && flown.target != "c99")
    throw Error(
        fmt::format("--target {}: only c99 (also for single and the deterministic policy) and cpp "
                    "(the fast policy) can be replayed",
                    flown.target));
  codegen::ExportOptions options;
  options.scalar = codegen::scalar_type(flown.scalar);
  options.weights = codegen::weight_type(flown.weights);
  if (!cpp) codegen::check_c99(model);
  return codegen::PreparedExport(model, options, cpp ? flown.max_error : "");
}

}  // namespace

FlownExport::FlownExport(const codegen::PreparedExport& prepared, const CompiledText& text)
    : answers_(kAnswerEstimate + prepared.model().nx()) {
  const codegen::Model& model = prepared.model();
  const std::string& name = prepared.name();
  const codegen::TextForm form = text.observer.form;
  const bool cpp = form == codegen::TextForm::kCpp, c99 = form == codegen::TextForm::kC99;
  const bool driven = model.nu() > 0;
  single_ = prepared.initialiser().scalar_bytes() == 4;
  settles_ =
      cpp ? model.nu() == 0 && codegen::linear_latent(model) != nullptr
          : text.observer.files.front().text.find(c99 ? name + "_warm_start(" : "warm_start(") != std::string::npos;
  std::vector<codegen::NamedText> files = text.observer.files;
  for (codegen::NamedText& file : files) file.path = fs::path(file.path).filename().string();
  if (cpp)
    for (const std::string& header : codegen::runtime_headers(files.front().text))
      files.push_back({header, std::string(codegen::embedded_text(header))});
  const std::string type = !cpp                 ? fmt::format("nlo::single::{}::Observer", name)
                           : text.deterministic ? fmt::format(
                                                      "nlo::SampledObserver<nlo::{}::Model, "
                                                      "nlo::Arithmetic::kDeterministic>",
                                                      name)
                                                : fmt::format("nlo::{}::Observer", name);
  files.push_back({c99 ? "main.c" : "main.cpp",
                   codegen::filled(codegen::embedded_text("flight/replay.c.in"),
                                   {{"NAME", name},
                                    {"OBSERVER", type},
                                    {"MADE_OF", cpp ? fmt::format("{{nlo::{}::kModel}}", name) : ""},
                                    {"SCALAR", prepared.initialiser().scalar_name()},
                                    {"NM", std::to_string(model.measured())},
                                    {"NU", std::to_string(model.nu())},
                                    {"NX", std::to_string(model.nx())},
                                    {"AND_U", driven ? ", u" : ""},
                                    {"READ_U", model.inputs.empty() ? "" : ", u"},  // without inputs that only drive z
                                    {"DRIVEN", driven ? "true" : ""},
                                    {"WARM_START", settles_ && !text.deterministic ? "true" : ""},
                                    {"CPP", c99 ? "" : "true"}})});
  folder_ = std::make_unique<codegen::TemporaryFolder>((fs::temp_directory_path() / "nlo-replay").string());
  for (const codegen::NamedText& file : files) write(folder_->name(), file.path, file.text);

  const char* chosen = std::getenv(c99 ? "CC" : "CXX");
  std::vector<std::string> command = codegen::words_of(text.compiler);
  if (command.empty()) command = codegen::words_of(chosen != nullptr ? chosen : "");
  if (command.empty()) command = codegen::words_of(c99 ? "cc -O1" : "c++ -O2");
  std::vector<std::string> rest = {"-std=c99", "main.c", name + ".c"};
  if (!c99) rest = {"-std=c++20", "-I.", "main.cpp"};
  command.insert(command.end(), rest.begin(), rest.end());
  command.insert(command.end(), {"-o", "flight"});
  const std::string failure = codegen::run_child(command, folder_->name(), kCompiling);
  if (!failure.empty())
    throw Error(fmt::format(
        "{}: an export is compiled here to replay it: install a {} compiler (gcc, clang), or "
        "name yours {}",
        failure, c99 ? "C" : "C++20", text.compiler.empty() ? c99 ? "in CC" : "in CXX" : "with --compiler"));
}

FlownExport::FlownExport(const codegen::Model& model, const Flown& flown)
    : FlownExport(prepared_of(model, flown), flown) {}

FlownExport::FlownExport(const codegen::PreparedExport& prepared, const Flown& flown)
    : FlownExport(prepared, {codegen::observers_in(codegen::export_target(flown.target).generate(prepared)).front(),
                             flown.compiler}) {
  name_ = fmt::format("--target {} --scalar {}", flown.target, flown.scalar);
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
