// SPDX-License-Identifier: MIT
#include "codegen/base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/temporary.h"

namespace nlo::codegen {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what, int reason) {
  throw Error(path + ": cannot " + what + ": " + std::generic_category().message(reason));
}

void write_all(int fd, std::string_view text, const std::string& path) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "write", errno);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

/// Writes `text` to `file`, sets its mode and syncs it to disk.
void fill(const TemporaryFile& file, std::string_view text, mode_t mode, const std::string& target) {
  write_all(file.descriptor(), text, target);
  if (::fchmod(file.descriptor(), mode) != 0) fail(target, "set the permissions", errno);
  if (::fsync(file.descriptor()) != 0) fail(target, "write", errno);
}

void replace(TemporaryFile& file, const std::string& target) {
  if (file.rename(target) != 0) fail(target, "replace", errno);
}

mode_t mode_of_new_files() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return static_cast<mode_t>(0666) & ~mask;
}

/// Returns the file that writing to `path` replaces. Follows links, also a link to a file that does not exist yet.
std::string target_of(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int kMostLinks = 40;  // the limit of the kernel
  fs::path target = path;
  std::error_code error;
  for (int i = 0; fs::is_symlink(fs::symlink_status(target, error)); ++i) {
    if (i == kMostLinks) fail(path, "follow the link", ELOOP);
    const fs::path next = fs::read_symlink(target, error);
    if (error) fail(path, "follow the link", error.value());
    target = target.parent_path() / next;  // an absolute path replaces the left part
  }
  return target.string();
}

}  // namespace

void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const Descriptor directory(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() >= 0) ::fsync(directory.get());
}

std::string read_file(const std::string& path, std::size_t max_bytes) {
  Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) fail(path, "open", errno);
  std::string text;
  struct stat found {};
  if (::fstat(fd.get(), &found) == 0 && S_ISREG(found.st_mode))
    text.reserve(std::min(static_cast<std::size_t>(found.st_size), max_bytes));
  char block[1 << 16];
  for (;;) {
    const ssize_t n = ::read(fd.get(), block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "read", errno);
    if (n == 0) return text;
    if (text.size() + static_cast<std::size_t>(n) > max_bytes)
      throw Error(path + ": larger than the " + std::to_string(max_bytes) +
                  " bytes that nlo reads at most; use a smaller file");
    text.append(block, static_cast<std::size_t>(n));
  }
}

void write_file_atomically(const std::string& path, std::string_view text) {
  struct stat found {};
  const bool exists = ::stat(path.c_str(), &found) == 0;
  if (exists && S_ISDIR(found.st_mode)) fail(path, "write", EISDIR);
  if (exists && !S_ISREG(found.st_mode)) {
    Descriptor fd(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (fd.get() < 0) fail(path, "open for writing", errno);
    return write_all(fd.get(), text, path);
  }
  const std::string target = target_of(path);
  TemporaryFile file(target);
  fill(file, text, exists ? found.st_mode & static_cast<mode_t>(07777) : mode_of_new_files(), target);
  replace(file, target);
  sync_folder_of(target);
}

void rewrite_file_atomically(const std::string& path, std::string_view read, std::string_view text) {
  if (read_file(path) != read) throw Error(path + ": has changed since it was read, so it was not replaced; run again");
  write_file_atomically(path, text);
}

void write_files_atomically(const std::vector<NamedText>& files) {
  struct Replacement {
    std::string target;
    std::optional<std::string> old;  ///< its old text
    TemporaryFile file;
  };
  std::vector<Replacement> replacements;
  for (const NamedText& wanted : files) {
    struct stat found {};
    const bool exists = ::stat(wanted.path.c_str(), &found) == 0;
    if (exists && !S_ISREG(found.st_mode)) fail(wanted.path, "replace what is not a regular file", EINVAL);
    const std::string target = target_of(wanted.path);
    std::optional<std::string> old;
    if (exists) old = read_file(target);
    replacements.push_back({target, std::move(old), TemporaryFile(target)});
    const Replacement& next = replacements.back();
    fill(next.file, wanted.text, exists ? found.st_mode & static_cast<mode_t>(07777) : mode_of_new_files(), target);
  }
  std::size_t done = 0;
  try {
    for (; done < replacements.size(); ++done) replace(replacements[done].file, replacements[done].target);
  } catch (const Error&) {
    while (done-- > 0) {
      const Replacement& undone = replacements[done];
      if (undone.old) {
        write_file_atomically(undone.target, *undone.old);
      } else {
        ::unlink(undone.target.c_str());
      }
    }
    throw;
  }
  for (const Replacement& made : replacements) sync_folder_of(made.target);
}

}  // namespace nlo::codegen
