// SPDX-License-Identifier: MIT
// A fixed set of threads that share numbered tasks. The result must not depend on the thread that runs a task: each
// task writes to its own place, and sums are formed in the order of the numbers.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace nlo::trainer {

class ThreadPool {
 public:
  /// threads: 0 uses all cores. If the system refuses some threads, the pool has one per core, or as many as have
  /// started, and says so once on stderr. Code that needs memory per thread asks threads().
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Runs task(index, thread) for each index in [0, count) and waits. `thread` in [0, threads()) selects the scratch
  /// memory. If tasks throw, the first exception is thrown again here.
  void run(int count, const std::function<void(int index, int thread)>& task);

 private:
  std::string start(int threads);  ///< returns an empty text, or the reason for fewer threads
  void stop();
  void work(int thread);
  void drain(int thread);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(int, int)>* task_ = nullptr;
  std::atomic<int> next_{0};
  int count_ = 0;
  std::atomic<int> busy_{0};
  std::atomic<unsigned long> generation_{0};
  std::atomic<bool> stopping_{false};
  std::exception_ptr failure_;
};

}  // namespace nlo::trainer
