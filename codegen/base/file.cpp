// SPDX-License-Identifier: MIT
#include "codegen/base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what, int reason) {
  throw Error(path + ": cannot " + what + ": " + std::generic_category().message(reason));
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  int close() { return ::close(std::exchange(fd_, -1)); }  // where a network file system reports its last error

 private:
  int fd_;
};

void write_all(int fd, std::string_view text, const std::string& path) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "write", errno);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

/// A new file beside `path`, removed again unless it is renamed into place.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path)
      : target_(path), name_(path + ".XXXXXX"), fd_(::mkstemp(name_.data())) {
    if (fd_.get() < 0) {
      const int reason = errno;
      name_.clear();
      fail(target_, "create a file beside it", reason);
    }
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  void write(std::string_view text, mode_t mode) {
    write_all(fd_.get(), text, target_);
    if (::fchmod(fd_.get(), mode) != 0) fail(target_, "set the permissions", errno);
    if (::fsync(fd_.get()) != 0) fail(target_, "write", errno);
    if (fd_.close() != 0) fail(target_, "write", errno);
  }

  void rename_to_target() {
    if (::rename(name_.c_str(), target_.c_str()) != 0) fail(target_, "replace", errno);
    name_.clear();
  }

 private:
  std::string target_, name_;
  Descriptor fd_;
};

/// The rename itself is on disk only when the directory is; a file system that cannot sync directories is let be.
void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const Descriptor directory(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() >= 0) ::fsync(directory.get());
}

mode_t mode_of_new_files() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return static_cast<mode_t>(0666) & ~mask;
}

}  // namespace

std::string read_file(const std::string& path, std::size_t max_bytes) {
  Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) fail(path, "open", errno);
  std::string text;
  char block[1 << 16];
  for (;;) {
    const ssize_t n = ::read(fd.get(), block, sizeof block);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "read", errno);
    if (n == 0) return text;
    if (text.size() + static_cast<std::size_t>(n) > max_bytes)
      throw Error(path + ": larger than the " + std::to_string(max_bytes) + " bytes that are read at most");
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
  const std::string target = exists ? std::filesystem::canonical(path).string() : path;
  TemporaryFile file(target);
  file.write(text, exists ? found.st_mode & static_cast<mode_t>(07777) : mode_of_new_files());
  file.rename_to_target();
  sync_folder_of(target);
}

void write_files_atomically(const std::vector<NamedText>& files) {
  struct Replacement {
    std::string target;
    std::optional<std::string> old;  ///< its text until now
    std::unique_ptr<TemporaryFile> file;
  };
  std::vector<Replacement> replacements;
  for (const NamedText& wanted : files) {
    struct stat found {};
    const bool exists = ::stat(wanted.path.c_str(), &found) == 0;
    if (exists && !S_ISREG(found.st_mode)) fail(wanted.path, "replace what is no regular file", EINVAL);
    Replacement& next = replacements.emplace_back();
    next.target = exists ? std::filesystem::canonical(wanted.path).string() : wanted.path;
    if (exists) next.old = read_file(next.target);
    next.file = std::make_unique<TemporaryFile>(next.target);
    next.file->write(wanted.text, exists ? found.st_mode & static_cast<mode_t>(07777) : mode_of_new_files());
  }
  std::size_t done = 0;
  try {
    for (; done < replacements.size(); ++done) replacements[done].file->rename_to_target();
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
