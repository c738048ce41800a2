// SPDX-License-Identifier: MIT
#include "codegen/base/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

extern char** environ;

namespace nlo::codegen {

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

ChildEnd end_of_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience, const std::string& output) {
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  constexpr mode_t kOwn = 0600;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "log.txt", kCreate, kOwn);
  if (output.empty()) posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  if (!output.empty()) posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), kCreate, kOwn);
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return {fmt::format("{} could not be started: {}", words[0], std::strerror(error))};

  int status = 0;
  const auto deadline = std::chrono::steady_clock::now() + patience;
  auto pause = std::chrono::microseconds(200);
  while (true) {
    const pid_t done = waitpid(child, &status, WNOHANG);
    if (done > 0) break;
    if (done < 0 && errno != EINTR) return {fmt::format("{} was lost: {}", words[0], std::strerror(errno))};
    if (std::chrono::steady_clock::now() > deadline) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return {fmt::format("{} did not finish within {} s", words[0], patience.count())};
    }
    std::this_thread::sleep_for(pause);
    if (pause < std::chrono::milliseconds(5)) pause *= 2;
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == 0) return {"", 0};
  std::ifstream file(directory + "/log.txt", std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string log = text.str().substr(0, 400);
  return {fmt::format("{} failed{}{}", words[0], log.empty() ? "" : ": ", log), code};
}

std::string run_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience) {
  return end_of_child(words, directory, patience).failure;
}

}  // namespace nlo::codegen
