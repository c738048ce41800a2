// SPDX-License-Identifier: MIT
// Lets only one program write to the folder of a run. Two programs would mix their checkpoints and models.
#pragma once

#include <chrono>
#include <string>

namespace nlo::trainer {

/// The lock is on the folder itself (flock), so it leaves no file behind, and it ends with the program in any case.
class DirectoryLock {
 public:
  DirectoryLock() = default;
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  ~DirectoryLock() { release(); }

  /// Locks the folder. Throws codegen::InputError if another program holds the lock for longer than `patience`. Does
  /// nothing if it is locked already, if the folder does not exist yet, and on a file system without locks.
  void take(const std::string& directory, std::chrono::milliseconds patience = {});

  void release();

 private:
  int descriptor_ = -1;
};

}  // namespace nlo::trainer
