// SPDX-License-Identifier: MIT
// The result of a run: durations, errors and status counts, as text for a reader and as JSON for the report.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

/// Durations [ns], collected without allocating.
class Durations {
 public:
  explicit Durations(std::size_t capacity) : values_ns_(capacity) {}

  void add(std::int64_t value_ns) {
    if (count_ < values_ns_.size()) values_ns_[count_++] = value_ns;
  }

  void sort() { std::sort(values_ns_.begin(), values_ns_.begin() + static_cast<std::ptrdiff_t>(count_)); }

  /// Returns the quantile: `share` of all values do not exceed it. Call sort() before.
  std::int64_t quantile(double share) const {
    return count_ == 0 ? 0 : values_ns_[static_cast<std::size_t>(share * static_cast<double>(count_ - 1))];
  }

  std::string to_json() const {
    char text[160];
    std::snprintf(text, sizeof text, R"({"p50": %lld, "p99": %lld, "p99_9": %lld, "max": %lld})", at(0.5), at(0.99),
                  at(0.999), at(1.0));
    return text;
  }

  /// Returns the counts in buckets, each a quarter wider than the one before. Call sort() before.
  std::string histogram_json() const {
    std::string text = "[";
    std::size_t first = 0;
    for (double limit_ns = 100.0; first < count_; limit_ns *= 1.25) {
      std::size_t last = first;
      while (last < count_ && static_cast<double>(values_ns_[last]) < limit_ns) ++last;
      if (last > first) {
        char bucket[80];
        std::snprintf(bucket, sizeof bucket, R"(%s{"below_ns": %.0f, "count": %zu})", text.size() > 1 ? ", " : "",
                      limit_ns, last - first);
        text += bucket;
      }
      first = last;
    }
    return text + "]";
  }

 private:
  long long at(double share) const { return static_cast<long long>(quantile(share)); }

  std::vector<std::int64_t> values_ns_;
  std::size_t count_ = 0;
};

/// Root of the mean squared norm of an error.
class RmsError {
 public:
  void add(double squared_norm) {
    sum_ += squared_norm;
    ++count_;
  }
  double value() const { return count_ == 0 ? 0.0 : std::sqrt(sum_ / static_cast<double>(count_)); }

 private:
  double sum_ = 0.0;
  std::size_t count_ = 0;
};
