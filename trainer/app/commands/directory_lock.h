// SPDX-License-Identifier: MIT
// One program at a time writes a run's folder: two would mix their checkpoints and models without a word.
#pragma once

#include <chrono>
#include <string>

namespace nlo::trainer {

/// The lock is the folder's own (flock), so that it leaves no file behind and ends with the program, however that ends.
class DirectoryLock {
 public:
  DirectoryLock() = default;
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  ~DirectoryLock() { release(); }

  /// Throws codegen::InputError while another program holds it, for longer than `patience`. Does nothing where it is
  /// held already, where there is no such folder yet, and on a file system that knows no locks.
  void take(const std::string& directory, std::chrono::milliseconds patience = {});

  void release();

 private:
  int descriptor_ = -1;
};

}  // namespace nlo::trainer
