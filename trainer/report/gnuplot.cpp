// SPDX-License-Identifier: MIT
#include "trainer/report/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "codegen/base/temporary.h"
#include "trainer/report/gnuplot_script.h"
#include "trainer/report/svg_text.h"

extern char** environ;

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

constexpr auto kPatience = std::chrono::seconds(60);

std::string file_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Runs `program -d plot.gp` in `directory`; empty when it ended well, else the reason.
std::string run(const std::string& program, const fs::path& directory) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "log.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::string name = program, no_user_settings = "-d", script = "plot.gp";
  char* const arguments[] = {name.data(), no_user_settings.data(), script.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fmt::format("{} could not be started: {}", program, std::strerror(error));

  int status = 0;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    const pid_t done = waitpid(child, &status, WNOHANG);
    if (done > 0) break;
    if (done < 0 && errno != EINTR) return fmt::format("{} was lost: {}", program, std::strerror(errno));
    if (std::chrono::steady_clock::now() > deadline) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return fmt::format("{} did not finish within {} s", program, kPatience.count());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  const std::string log = file_text(directory / "log.txt").substr(0, 400);
  return fmt::format("{} failed{}{}", program, log.empty() ? "" : ": ", log);
}

}  // namespace

Eigen::VectorXd thinned(const Eigen::VectorXd& values, Eigen::Index points) {
  const Eigen::Index step = std::max<Eigen::Index>(1, (values.size() + points - 1) / points);
  return values(Eigen::seqN(0, (values.size() + step - 1) / step, step));
}

std::string figure_label(const Figure& figure) {
  std::vector<std::string> heights, widths, names;
  const auto note_once = [](std::vector<std::string>& known, const std::string& name) {
    if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
  };
  for (const Panel& panel : figure.panels) {
    note_once(heights, panel.heat_map ? panel.heat_map->label : panel.y_label);
    note_once(widths, panel.x_label);
    for (const Series& series : panel.series) note_once(names, series.title);
  }
  return fmt::format("{}{}{}{}{}", fmt::join(heights, ", "), heights.empty() || widths.empty() ? "" : " over ",
                     fmt::join(widths, ", "), names.empty() ? "" : ": ", fmt::join(names, ", "));
}

Drawing draw(const std::vector<Figure>& figures, const std::string& program) {
  Drawing drawing;
  if (figures.empty()) return drawing;
  std::optional<codegen::TemporaryFolder> made;
  try {
    made.emplace((fs::temp_directory_path() / "nlo-plots").string());
  } catch (const std::exception& error) {  // an Error, or the file system's
    drawing.failure = error.what();
    return drawing;
  }
  const fs::path directory = made->name();
  std::string script;
  bool written = true;
  for (std::size_t i = 0; i < figures.size(); ++i) script += figure_script(figures[i], i, directory, written);
  written = write_text(directory / "plot.gp", script) && written;
  drawing.failure = written ? run(program, directory) : "the plots' data could not be written";
  if (!drawing.failure.empty()) return drawing;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    drawing.svgs.push_back(inline_svg(file_text(directory / fmt::format("{}.svg", i)), figure_label(figures[i])));
    if (drawing.svgs.back().empty()) drawing.failure = fmt::format("{} drew nothing", program);
  }
  if (!drawing.failure.empty()) drawing.svgs.clear();
  return drawing;
}

}  // namespace nlo::trainer
