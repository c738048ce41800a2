// SPDX-License-Identifier: MIT
#include "trainer/choose/resonances.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "trainer/base/draws.h"

namespace nlo::trainer {
namespace {

constexpr double kWorthAPair = 0.1;  // least decrease of the log error
constexpr int kMostPairs = 3;

struct Resonance {
  double frequency;  ///< |lambda| [1/s]
  double damping;    ///< -re / |lambda|
};

ModeBank with_pair(ModeBank bank, const Resonance& r) {
  const double re = -r.damping * r.frequency, im = r.frequency * std::sqrt(1.0 - r.damping * r.damping);
  bank.pairs.push_back({rounded(re), rounded(im)});
  return bank;
}

class Search {
 public:
  Search(double sample_period_s, double longest_s, const std::function<double(const ModeBank&)>& log_error)
      : fastest_(1.5 / sample_period_s), slowest_(1.0 / longest_s), log_error_(log_error) {}

  /// Returns the bank with the best additional pair, and sets `error` to its error.
  ModeBank best_pair(const ModeBank& bank, double& error) const {
    constexpr double kDamping = 0.1, kApart = 1.2;  // neighbours of the grid overlap by half of their bandwidth
    Resonance best{0.0, kDamping};
    const auto look = [&](const Resonance& r) {
      if (r.frequency > fastest_ || r.damping * r.frequency < slowest_) return;
      const double other = log_error_(with_pair(bank, r));
      if (!(other < error)) return;
      error = other;
      best = r;
    };
    for (double frequency = slowest_ / kDamping; frequency <= fastest_; frequency *= kApart)
      look({frequency, kDamping});
    if (best.frequency == 0.0) return bank;
    for (const double step : {1.1, 1.05, 1.025, 1.0125}) {
      const Resonance from = best;
      for (const double slower : {1.0 / step, 1.0, step})
        for (const double factor : {0.5, 1.0, 2.0})
          look({from.frequency * slower, std::clamp(from.damping * factor, 0.002, 0.7)});
    }
    return with_pair(bank, best);
  }

 private:
  double fastest_, slowest_;
  const std::function<double(const ModeBank&)>& log_error_;
};

}  // namespace

ModeBank with_resonances(const ModeBank& bank, double sample_period_s, double longest_s, int most_rows,
                         const std::function<double(const ModeBank&)>& log_error) {
  const Search search(sample_period_s, longest_s, log_error);
  ModeBank result = bank;
  double error = log_error(bank);
  for (int pair = 0; pair < kMostPairs && result.rows() + 2 <= most_rows; ++pair) {
    double with = error;
    ModeBank next = search.best_pair(result, with);
    if (with > error - kWorthAPair) break;
    result = std::move(next);
    ++result.resonances;
    error = with;
  }
  return result;
}

}  // namespace nlo::trainer
