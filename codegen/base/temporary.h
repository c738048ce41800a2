// SPDX-License-Identifier: MIT
// Temporary files and folders that outlive no program for long: each is locked (flock) by the program that makes it,
// and what a killed one has left, which nobody locks, is removed by the next that makes another.
#pragma once

#include <string>
#include <utility>

namespace nlo::codegen {

/// An open file or folder, closed at the end; -1: none.
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

/// A new empty file at "`path`.nlo-XXXXXX", removed again unless it is renamed.
class TemporaryFile {
 public:
  /// Throws Error, which names `path`.
  explicit TemporaryFile(const std::string& path);
  TemporaryFile(TemporaryFile&& other) noexcept : name_(std::exchange(other.name_, {})), fd_(std::move(other.fd_)) {}
  ~TemporaryFile();

  int descriptor() const { return fd_.get(); }
  /// What rename() of the system returns.
  int rename(const std::string& to);

 private:
  std::string name_;
  Descriptor fd_;
};

/// A new empty folder at "`path`.nlo-XXXXXX", for this user alone, removed again with all that is in it unless it is
/// renamed.
class TemporaryFolder {
 public:
  /// Throws Error, which names `path`.
  explicit TemporaryFolder(const std::string& path);
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::string& name() const { return name_; }
  /// What rename() of the system returns.
  int rename(const std::string& to);
  void keep() { name_.clear(); }

 private:
  std::string name_;
  Descriptor fd_;
};

/// What is at `path`, locked: waits until no other program holds it, and sees what that put in its place. None where it
/// cannot be opened.
Descriptor hold(const std::string& path);

}  // namespace nlo::codegen
