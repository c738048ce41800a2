// SPDX-License-Identifier: MIT
#include "trainer/app/commands/directory_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "codegen/base/error.h"

namespace nlo::trainer {

void DirectoryLock::take(const std::string& directory, std::chrono::milliseconds patience) {
  if (descriptor_ >= 0) return;
  const int opened = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;  // a later write reports the reason
  const auto give_up = std::chrono::steady_clock::now() + patience;
  int reason = 0;
  do {
    if (::flock(opened, LOCK_EX | LOCK_NB) == 0) {
      descriptor_ = opened;
      return;
    }
    reason = errno;
    if (patience.count() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  } while (reason == EWOULDBLOCK && std::chrono::steady_clock::now() < give_up);
  ::close(opened);
  if (reason == EWOULDBLOCK)
    throw codegen::InputError(
        directory + ": another nlo is using this folder; wait until it ends, or choose another one with -o DIR");
}

void DirectoryLock::release() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace nlo::trainer
