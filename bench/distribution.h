// SPDX-License-Identifier: MIT
// Collects the durations of single calls, because a control loop depends on the slowest call, not on the mean.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace nlo::bench {

/// Durations [ns]. Adding one does not allocate.
class Distribution {
 public:
  Distribution(std::string name, std::size_t capacity) : name_(std::move(name)), values_ns_(capacity) {}

  void add(std::int64_t value_ns) {
    if (count_ < values_ns_.size()) values_ns_[count_++] = value_ns;
  }
  void sort() {
    values_ns_.resize(count_);
    std::ranges::sort(values_ns_);
  }

  const std::string& name() const { return name_; }
  /// Returns the values. Call sort() before.
  const std::vector<std::int64_t>& values_ns() const { return values_ns_; }
  /// Returns the value that this share of all values does not exceed. Call sort() before.
  double quantile_ns(double share) const {
    if (count_ == 0) return 0.0;
    return static_cast<double>(values_ns_[static_cast<std::size_t>(share * static_cast<double>(count_ - 1))]);
  }

 private:
  std::string name_;
  std::vector<std::int64_t> values_ns_;
  std::size_t count_ = 0;
};

/// One panel of histograms over a logarithmic axis that starts at 0.1 us.
struct HistogramPanel {
  std::string title;
  std::vector<const Distribution*> distributions;
};

/// Draws the panels below each other as an SVG file by gnuplot. Returns an empty text, or the reason why there is no
/// file.
std::string draw_histograms(const std::vector<HistogramPanel>& panels, const std::string& path);

}  // namespace nlo::bench
