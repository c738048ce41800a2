// SPDX-License-Identifier: MIT
#include "tests/commands/program.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

std::string slurp(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

const std::string kTinyExperiment = R"(name = "tiny"

[plant]
model = "van_der_pol"

[simulation]
horizon_s = 12.0
sample_period_s = 0.05
trajectories = 4
initial_low = [-1, -1]
initial_high = [1, 1]

[observer]
eigenvalues = [-1.0, -2.0, -3.0]

[inverse_map]
hidden = [8]

[training]
steps = 20
trajectories_per_step = 4
samples_per_step = 64
noise = "gaussian:0.1"
)";

const std::string kTinyLogExperiment = R"(name = "tiny_log"

[log]
train_files = ["a.csv"]
validation_files = ["b.csv"]

[[log.columns]]
name = "time"
role = "time"

[[log.columns]]
name = "y"
role = "output"
unit = "m"

[[log.columns]]
name = "v"
role = "state"
unit = "m/s"
derivative_of = "y"

[observer]
eigenvalues = [-10.0, -30.0]
features = "latent_and_output"

[inverse_map]
hidden = [8]

[training]
steps = 20
learning_rate = 0.1
trajectories_per_step = 1
samples_per_step = 64
)";

std::string tiny_log(double phase, int samples) {
  std::string text = "time,y\n";
  for (int k = 0; k < samples; ++k)
    text.append(shortest_text(0.01 * k)).append(",").append(shortest_text(std::sin(0.01 * k + phase))).append("\n");
  return text;
}

std::string with(std::string text, const std::string& old, const std::string& replacement) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  if (at != std::string::npos) text.replace(at, old.size(), replacement);
  return text;
}

bool Scratch::has(const std::string& file) const {
  return fs::exists(path(file));
}

std::map<std::string, std::string> Scratch::contents() const {
  std::map<std::string, std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(path())) {
    const std::string name = fs::relative(entry.path(), path()).string();
    if (entry.is_directory()) {
      found[name + "/"] = "";
    } else {
      found[name] = slurp(entry.path());
    }
  }
  return found;
}

ProgramResult Scratch::run(const std::vector<std::string>& arguments, const std::string& interrupt_at) const {
  return run_program(NLO_PROGRAM, arguments, interrupt_at);
}

ProgramResult Scratch::ok(const std::vector<std::string>& arguments) const {
  ProgramResult result = run(arguments);
  if (result.exit_code != 0) throw std::runtime_error("nlo " + arguments.front() + " failed: " + result.err);
  return result;
}

std::string Scratch::refusal(int exit_code, const std::vector<std::string>& arguments) const {
  const ProgramResult result = run(arguments);
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  return result.err;
}

ProgramResult Scratch::run_program(const std::string& program, const std::vector<std::string>& arguments,
                                   const std::string& interrupt_at) const {
  // Beside the folder, because they are not files of the program.
  const std::string out = path() + ".out", err = path() + ".err";
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr unsigned kLongest_s = 300;
    ::alarm(kLongest_s);
    const bool ready = ::chdir(path().c_str()) == 0 && std::freopen("/dev/null", "r", stdin) != nullptr &&
                       std::freopen(out.c_str(), "w", stdout) != nullptr &&
                       std::freopen(err.c_str(), "w", stderr) != nullptr;
    if (ready) ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (!interrupt_at.empty()) {
    while (::waitpid(child, &status, WNOHANG) == 0) {
      if (slurp(err).find(interrupt_at) == std::string::npos) {
        ::usleep(5000);
        continue;
      }
      ::kill(child, SIGINT);
      ::waitpid(child, &status, 0);
      break;
    }
  } else {
    ::wait4(child, &status, 0, &usage);
  }
  ProgramResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err),
                       static_cast<double>(usage.ru_maxrss) / 1024.0};
  fs::remove(out);
  fs::remove(err);
  return result;
}

}  // namespace nlo::trainer
