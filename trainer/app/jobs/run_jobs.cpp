// SPDX-License-Identifier: MIT
#include "trainer/app/jobs/run_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <mutex>
#include <thread>

#include "trainer/base/parallel.h"

namespace nlo::trainer {

void JobsResult::check() const {
  if (!failures.empty()) std::rethrow_exception(failures.front());
}

std::string JobsResult::interrupted_text(const std::string& command) const {
  return fmt::format("interrupted with {} of {} trainings left; {}", left, done + found + left + failures.size(),
                     command.empty() ? "with -o DIR, finished trainings are stored" : "to continue: " + command);
}

JobsResult run_jobs(const std::vector<Job>& jobs, const JobsOptions& options) {
  const int count = static_cast<int>(jobs.size());
  const int threads =
      options.threads > 0 ? options.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int at_once = options.side_by_side ? std::clamp(count, 1, threads) : 1;
  const auto stopped = [&] { return options.stop != nullptr && options.stop->load(); };
  if (options.progress != nullptr)
    for (const Job& job : jobs) options.progress->expect(job.cost_s, 1);

  JobsResult result;
  std::mutex mutex;
  ThreadPool(at_once).run(count, [&](int index, int) {
    {
      const std::lock_guard lock(mutex);
      if (stopped() || (!options.keep_going && !result.failures.empty())) return;
    }
    const Job& job = jobs[static_cast<std::size_t>(index)];
    double done = 0.0;
    const auto advance = [&](double share) {
      share = std::max(share, done);  // a job may train more than once
      if (options.progress != nullptr) options.progress->advance(job.cost_s * (share - done), "training " + job.name);
      done = share;
    };
    try {
      const JobEnd end = job.work({job.name, threads / at_once, options.stop, advance});
      if (end == JobEnd::kStopped) return;
      if (options.progress != nullptr && end == JobEnd::kFound) options.progress->expect(-job.cost_s, -1);
      if (options.progress != nullptr && end == JobEnd::kDone)
        options.progress->model_done(job.cost_s * (1.0 - done), job.name);
      const std::lock_guard lock(mutex);
      ++(end == JobEnd::kFound ? result.found : result.done);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!stopped()) result.failures.push_back(std::current_exception());
    }
  });
  result.left = jobs.size() - result.done - result.found - result.failures.size();
  return result;
}

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only use lock-free variables");

extern "C" void request_stop(int signal) {
  stop_requested.store(true);
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& stop_on_interrupt() {
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  return stop_requested;
}

}  // namespace nlo::trainer
