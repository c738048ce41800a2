// SPDX-License-Identifier: MIT
#include "codegen/base/directory.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

namespace fs = std::filesystem;

std::string line_of(const NamedText& file) {
  std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a
  for (const char c : file.text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return fmt::format("{:016x} {}\n", hash, file.path);
}

std::string manifest_of(const std::vector<NamedText>& files) {
  std::map<std::string, std::string> lines;
  for (const NamedText& file : files) lines[file.path] = line_of(file);
  std::string text = "Made by nlo export, which replaces this folder only while all of it is as listed here.\n";
  for (const auto& [path, line] : lines) text += line;
  return text;
}

/// What stands in `folder`, but for its manifest.
std::vector<NamedText> contents_of(const fs::path& folder) {
  std::vector<NamedText> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (name == kManifest || (entry.is_directory() && !entry.is_symlink())) continue;
    // A link or a socket was not generated: its empty text is nobody's.
    const bool regular = entry.is_regular_file() && !entry.is_symlink();
    files.push_back({name, regular ? read_file(entry.path().string()) : ""});
  }
  return files;
}

/// Throws unless nothing is lost when `folder` is replaced.
void check_replaceable(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw Error(folder.string() + ": is no folder; choose another one with -o");
  if (fs::is_empty(folder)) return;
  const fs::path manifest = folder / kManifest;
  if (!fs::is_regular_file(manifest))
    throw Error(folder.string() + ": this folder was not made by nlo export; choose another one with -o");
  const std::string listed = read_file(manifest.string());
  const std::vector<NamedText> files = contents_of(folder);
  for (const NamedText& file : files)
    if (listed.find("\n" + line_of(file)) == std::string::npos)
      throw Error(
          fmt::format("{}: was added or changed since nlo export made this folder; move it away, or choose "
                      "another folder with -o",
                      (folder / file.path).string()));
}

/// A new folder beside `path`, removed again with all that is in it unless it is renamed.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& path) : name_(path.string() + ".XXXXXX") {
    if (::mkdtemp(name_.data()) != nullptr) return;
    const int reason = errno;
    name_.clear();
    throw Error(path.string() + ": cannot make a folder beside it: " + std::generic_category().message(reason));
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!name_.empty()) fs::remove_all(name_, ignored);
  }

  const std::string& name() const { return name_; }
  void rename(const fs::path& to) { fs::rename(std::exchange(name_, {}), to); }

 private:
  std::string name_;
};

void write(const fs::path& target, const std::vector<NamedText>& files) {
  TemporaryFolder made(target);
  for (const NamedText& file : files) {
    const fs::path path = fs::path(made.name()) / file.path;
    fs::create_directories(path.parent_path());
    write_file_atomically(path.string(), file.text);
  }
  write_file_atomically((fs::path(made.name()) / kManifest).string(), manifest_of(files));
  const mode_t mask = ::umask(0);
  ::umask(mask);
  fs::permissions(made.name(), static_cast<fs::perms>(0777U & ~mask));  // mkdtemp's own are for one user

  if (!fs::exists(fs::symlink_status(target))) return made.rename(target);
  const fs::path place = fs::canonical(target);
  check_replaceable(place);
  TemporaryFolder old(place);  // an empty folder can be renamed over
  fs::rename(place, old.name());
  try {
    made.rename(place);
  } catch (const fs::filesystem_error&) {
    old.rename(place);
    throw;
  }
}

/// Runs `work` on the folder that `path` names. Throws Error where the file system does.
template <class Work>
void with_target(const std::string& path, const Work& work) {
  fs::path target = fs::path(path).lexically_normal();
  if (!target.has_filename()) target = target.parent_path();  // DIR/
  if (target.empty() || target == "." || target == ".." || target == "/")
    throw Error(fmt::format("\"{}\" cannot be replaced by a new folder; choose another one with -o", path));
  try {
    work(target);
  } catch (const fs::filesystem_error& error) {
    throw Error(fmt::format("{}: {}", path, error.code().message()));
  }
}

}  // namespace

void check_directory(const std::string& path) {
  with_target(path, [](const fs::path& target) {
    if (fs::exists(target)) return check_replaceable(target);
    const fs::path parent = target.has_parent_path() ? target.parent_path() : ".";
    if (!fs::is_directory(parent))
      throw Error(fmt::format("{}: there is no directory {}; make it first", target.string(), parent.string()));
  });
}

void write_directory_atomically(const std::string& path, const std::vector<NamedText>& files) {
  with_target(path, [&files](const fs::path& target) { write(target, files); });
}

}  // namespace nlo::codegen
