// SPDX-License-Identifier: MIT
// A fixed set of threads that share out numbered tasks. Which thread runs a task must not matter: tasks write to
// places of their own, and code that adds them up does so in the order of their numbers.
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
  /// threads: 0 takes all cores. If the system refuses some of them, the pool has one for each core, or as many as
  /// there are, and says so once on stderr. Code that needs memory for each thread asks threads().
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Runs task(index, thread) for each index in [0, count) and waits. `thread` in [0, threads()) names the scratch
  /// memory to use. The first exception of a task is thrown again here.
  void run(int count, const std::function<void(int index, int thread)>& task);

 private:
  std::string start(int threads);  ///< empty, or why there are fewer
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
