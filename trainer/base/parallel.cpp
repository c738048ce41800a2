// SPDX-License-Identifier: MIT
#include "trainer/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <new>
#include <string>
#include <system_error>

namespace nlo::trainer {
namespace {

/// Says once in a program that fewer threads have started. Pools come and go, but the limit stays.
void say_fewer(int started, int wanted, const std::string& reason) {
  static std::atomic<bool> said{false};
  if (said.exchange(true)) return;
  std::fprintf(stderr, "nlo: runs on %d of %d threads (%s); the result is the same, but takes longer\n", started,
               wanted, reason.c_str());
}

/// Checks a condition repeatedly for some time before the caller sleeps. A training step has four rounds of some 100
/// us, and waking a thread takes a good part of one. Other work gets the core in the meantime. Returns true if the
/// condition came true.
template <class Condition>
bool came_true_soon(const Condition& condition) {
  constexpr int kLooks = 200;  // some 50 us
  for (int look = 0; look < kLooks; ++look) {
    if (condition()) return true;
    std::this_thread::yield();
  }
  return false;
}

}  // namespace

ThreadPool::ThreadPool(int threads) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int wanted = threads > 0 ? threads : cores;
  const std::string refusal = start(wanted);
  if (refusal.empty()) return;
  // More threads than cores would only use memory that the work needs.
  if (this->threads() > cores) {
    stop();
    start(cores);
  }
  say_fewer(this->threads(), wanted, refusal);
}

ThreadPool::~ThreadPool() {
  stop();
}

std::string ThreadPool::start(int threads) {
  try {
    workers_.reserve(static_cast<std::size_t>(threads - 1));
    for (int t = 1; t < threads; ++t) workers_.emplace_back([this, t] { work(t); });
  } catch (const std::system_error& error) {  // limit on processes or on address space
    return error.code().message();
  } catch (const std::bad_alloc&) {
    return "not enough memory";
  }
  return "";
}

void ThreadPool::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (auto& worker : workers_) worker.join();
  workers_.clear();
  stopping_ = false;
}

void ThreadPool::run(int count, const std::function<void(int, int)>& task) {
  {
    const std::lock_guard lock(mutex_);
    task_ = &task;
    count_ = count;
    next_ = 0;
    busy_ = static_cast<int>(workers_.size());
    failure_ = nullptr;
    ++generation_;
  }
  wake_.notify_all();
  drain(0);
  const auto done = [this] { return busy_ == 0; };
  came_true_soon(done);
  std::unique_lock lock(mutex_);
  done_.wait(lock, done);
  if (failure_) std::rethrow_exception(failure_);
}

void ThreadPool::work(int thread) {
  unsigned long seen = 0;
  for (;;) {
    const auto wanted = [&] { return stopping_ || generation_ != seen; };
    if (!came_true_soon(wanted)) {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, wanted);
    }
    if (stopping_) return;
    seen = generation_;
    drain(thread);
    {
      const std::lock_guard lock(mutex_);
      if (--busy_ == 0) done_.notify_one();
    }
  }
}

void ThreadPool::drain(int thread) {
  for (int index = next_++; index < count_; index = next_++) {
    try {
      (*task_)(index, thread);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }
}

}  // namespace nlo::trainer
