// SPDX-License-Identifier: MIT
#include "codegen/base/temporary.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <new>
#include <string_view>
#include <system_error>
#include <vector>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

namespace fs = std::filesystem;

constexpr char kMark[] = ".nlo-";
constexpr std::size_t kRandomSize = 6;

/// Waits for the lock. On a file system without locks the program continues without it.
void lock(int fd) {
  while (::flock(fd, LOCK_EX) != 0 && errno == EINTR) {
  }
}

/// Returns true if `name` is still the file that `fd` was opened for.
bool is_at(int fd, const std::string& name) {
  struct stat opened {
  }, found{};
  return ::fstat(fd, &opened) == 0 && ::lstat(name.c_str(), &found) == 0 && opened.st_dev == found.st_dev &&
         opened.st_ino == found.st_ino;
}

void remove_if_left(const fs::path& path) {
  const Descriptor fd(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat found {};
  if (fd.get() < 0 || ::fstat(fd.get(), &found) != 0 || found.st_uid != ::geteuid()) return;
  if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0) return;  // in use, or a file system without locks
  std::error_code ignored;
  if (is_at(fd.get(), path.string())) fs::remove_all(path, ignored);
}

/// Removes temporary files that killed programs have left beside `path`. A file that cannot be removed stays; it does
/// no harm.
void remove_leftovers(const std::string& path) {
  const fs::path target(path);
  const std::string start = target.filename().string() + kMark;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder.c_str()), ::closedir);
  // Lists all of them first, because a file that is removed during the search may be seen twice or not at all.
  std::vector<fs::path> found;
  while (const dirent* const entry = entries ? ::readdir(entries.get()) : nullptr) {
    const std::string_view name = entry->d_name;
    if (name.size() == start.size() + kRandomSize && name.starts_with(start)) found.push_back(folder / name);
  }
  for (const fs::path& leftover : found) remove_if_left(leftover);
}

/// Makes a file and locks it. Another program may remove the file as a leftover before it is locked; then this is
/// repeated with a new file.
template <class Make>
Descriptor make_locked(const std::string& path, std::string& name, const Make& make) {
  remove_leftovers(path);
  for (;;) {
    name = path + kMark + std::string(kRandomSize, 'X');
    Descriptor fd(make(name));
    if (fd.get() < 0) return fd;
    lock(fd.get());
    if (is_at(fd.get(), name)) return fd;
  }
}

[[noreturn]] void refuse(const std::string& path, const char* what, int reason) {
  throw Error(path + ": cannot make a " + what + " beside it: " + std::generic_category().message(reason));
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}

Descriptor hold(const std::string& path) {
  for (;;) {
    Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (fd.get() < 0) return fd;
    lock(fd.get());
    if (is_at(fd.get(), path)) return fd;
  }
}

TemporaryFile::TemporaryFile(const std::string& path) {
  fd_ = make_locked(path, name_, [](std::string& name) { return ::mkostemp(name.data(), O_CLOEXEC); });
  if (fd_.get() >= 0) return;
  const int reason = errno;
  refuse(path, "file", reason);
}

TemporaryFile::~TemporaryFile() {
  if (!name_.empty()) ::unlink(name_.c_str());
}

int TemporaryFile::rename(const std::string& to) {
  const int result = ::rename(name_.c_str(), to.c_str());
  if (result == 0) name_.clear();
  return result;
}

TemporaryFolder::TemporaryFolder(const std::string& path) {
  fd_ = make_locked(path, name_, [](std::string& name) {
    for (const std::string pattern = name;; name = pattern) {
      if (::mkdtemp(name.data()) == nullptr) return -1;
      const int fd = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (fd >= 0) return fd;
      const int reason = errno;
      if (reason == ENOENT) continue;  // another program removed it before it was locked
      ::rmdir(name.c_str());
      errno = reason;
      return -1;
    }
  });
  if (fd_.get() >= 0) return;
  const int reason = errno;
  refuse(path, "folder", reason);
}

TemporaryFolder::~TemporaryFolder() {
  if (!name_.empty()) try {
      std::error_code ignored;
      fs::remove_all(name_, ignored);
    } catch (const std::bad_alloc&) {  // the file stays until the next one is made
    }
}

int TemporaryFolder::rename(const std::string& to) {
  const int result = ::rename(name_.c_str(), to.c_str());
  if (result == 0) name_.clear();
  return result;
}

}  // namespace nlo::codegen
