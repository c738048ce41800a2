// SPDX-License-Identifier: MIT
// Temporary files and folders. The program that makes one holds a lock on it (flock). If the program is killed, the
// lock is gone, and the next program that makes a temporary file there removes the old one.
#pragma once

#include <string>
#include <utility>

namespace nlo::codegen {

/// Owns a file descriptor; -1: none.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  int get() const { return fd_; }

 private:
  int fd_;
};

/// A new empty file "`path`.nlo-XXXXXX". The destructor removes it unless it was renamed.
class TemporaryFile {
 public:
  /// Throws Error, which names `path`.
  explicit TemporaryFile(const std::string& path);
  TemporaryFile(TemporaryFile&& other) noexcept : name_(std::exchange(other.name_, {})), fd_(std::move(other.fd_)) {}
  ~TemporaryFile();

  int descriptor() const { return fd_.get(); }
  /// Renames the file. Returns the result of the system's rename().
  int rename(const std::string& to);

 private:
  std::string name_;
  Descriptor fd_;
};

/// A new empty folder "`path`.nlo-XXXXXX" that only this user can access. The destructor removes it with its contents
/// unless it was renamed.
class TemporaryFolder {
 public:
  /// Throws Error, which names `path`.
  explicit TemporaryFolder(const std::string& path);
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::string& name() const { return name_; }
  /// Renames the folder. Returns the result of the system's rename().
  int rename(const std::string& to);
  void keep() { name_.clear(); }

 private:
  std::string name_;
  Descriptor fd_;
};

/// Opens and locks `path`. Waits until no other program holds the lock, and opens the file that is there then. Returns
/// no descriptor if it cannot be opened.
Descriptor hold(const std::string& path);

}  // namespace nlo::codegen
