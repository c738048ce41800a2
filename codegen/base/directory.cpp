// SPDX-License-Identifier: MIT
#include "codegen/base/directory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <map>
#include <system_error>

#include "codegen/base/error.h"
#include "codegen/base/temporary.h"

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
  std::string text = "Made by nlo, which replaces this folder only while all of it is as listed here.\n";
  for (const auto& [path, line] : lines) text += line;
  return text;
}

/// Reads all files of `folder` except its manifest.
std::vector<NamedText> contents_of(const fs::path& folder) {
  std::vector<NamedText> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (name == kManifest || (entry.is_directory() && !entry.is_symlink())) continue;
    // A link or a socket was not generated; its text counts as empty.
    const bool regular = entry.is_regular_file() && !entry.is_symlink();
    files.push_back({name, regular ? read_file(entry.path().string()) : ""});
  }
  return files;
}

void check_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw Error(folder.string() + ": is not a folder; choose another one with -o");
  if (!fs::is_empty(folder) && !fs::is_regular_file(folder / kManifest))
    throw Error(folder.string() + ": this folder was not made by nlo; choose another one with -o");
}

/// Throws Error if files of a user would be lost when `folder` is replaced.
void check_replaceable(const fs::path& folder) {
  check_folder(folder);
  if (fs::is_empty(folder)) return;
  const std::string listed = read_file((folder / kManifest).string());
  const std::vector<NamedText> files = contents_of(folder);
  for (const NamedText& file : files)
    if (listed.find("\n" + line_of(file)) == std::string::npos)
      throw Error(
          fmt::format("{}: was added or changed since nlo made this folder; move it away, or choose "
                      "another folder with -o",
                      (folder / file.path).string()));
}

/// Locks a folder that may be replaced. Folders that are no exports are refused before, so exports wait only for
/// exports.
Descriptor hold_replaceable(const fs::path& folder) {
  check_folder(folder);
  Descriptor held = hold(folder.string());
  check_replaceable(folder);
  return held;
}

[[noreturn]] void fail(const fs::path& target, int reason) {
  throw Error(
      fmt::format("{}: cannot replace the folder: {}", target.string(), std::generic_category().message(reason)));
}

/// Syncs the folders; their files are on disk already.
void sync_folders(const std::string& folder) {
  sync_folder_of(folder + "/.");
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_directory()) sync_folder_of((entry.path() / ".").string());
}

/// Exchanges both names in one step, so that a reader always finds a folder. Returns the system's error number, or 0.
int exchange(const std::string& made, const fs::path& place) {
  return ::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, place.c_str(), RENAME_EXCHANGE) == 0 ? 0 : errno;
}

/// Replaces the folder `place` by `made`. On an Error `place` is unchanged.
void replace(TemporaryFolder& made, const fs::path& place) {
  const Descriptor held = hold_replaceable(place);  // held also while the folder has a temporary name
  const int refusal = exchange(made.name(), place);
  if (refusal == 0) {
    try {
      check_replaceable(made.name());  // a user may have added a file since the first check
    } catch (const std::exception&) {
      if (exchange(made.name(), place) != 0) made.keep();
      throw;
    }
    return;  // `made` is the old folder now, and is removed
  }
  if (refusal != EINVAL && refusal != ENOSYS) fail(place, refusal);
  TemporaryFolder old(place.string());  // rename() can replace an empty folder
  if (::rename(place.c_str(), old.name().c_str()) != 0) fail(place, errno);
  if (made.rename(place.string()) == 0) return;
  const int reason = errno;
  old.rename(place.string());
  fail(place, reason);
}

void write(const fs::path& target, const std::vector<NamedText>& files) {
  const bool is_new = !fs::exists(fs::symlink_status(target));
  const fs::path place = is_new ? target : fs::canonical(target);
  if (is_new && place.has_parent_path()) fs::create_directories(place.parent_path());
  TemporaryFolder made(place.string());
  for (const NamedText& file : files) {
    const fs::path path = fs::path(made.name()) / file.path;
    fs::create_directories(path.parent_path());
    write_file_atomically(path.string(), file.text);
  }
  write_file_atomically((fs::path(made.name()) / kManifest).string(), manifest_of(files));
  const mode_t mask = ::umask(0);
  ::umask(mask);
  fs::permissions(made.name(), static_cast<fs::perms>(0777U & ~mask));  // mkdtemp allows access for one user only
  sync_folders(made.name());
  // Another program may make the folder in the meantime; then it is replaced.
  const bool is_done = is_new && made.rename(place.string()) == 0;
  if (!is_done) {
    if (is_new && errno != ENOTEMPTY && errno != EEXIST && errno != ENOTDIR) fail(place, errno);
    replace(made, place);
  }
  sync_folder_of(place.string());
}

/// Runs `work` on the folder `path`. Turns errors of the file system into Error.
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
    if (fs::exists(target)) {
      const Descriptor held = hold_replaceable(target);
      return;
    }
    if (fs::is_symlink(fs::symlink_status(target)))
      throw Error(target.string() + ": is a link to a folder that does not exist; create that folder first");
    fs::path above = fs::absolute(target).parent_path();
    while (above.has_relative_path() && !fs::exists(fs::symlink_status(above))) above = above.parent_path();
    if (!fs::is_directory(above))
      throw Error(fmt::format("{}: {} is not a folder; choose another one with -o", target.string(), above.string()));
  });
}

void write_directory_atomically(const std::string& path, const std::vector<NamedText>& files) {
  with_target(path, [&files](const fs::path& target) { write(target, files); });
}

}  // namespace nlo::codegen
