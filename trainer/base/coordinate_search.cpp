// SPDX-License-Identifier: MIT
#include "trainer/base/coordinate_search.h"

namespace nlo::trainer {

Tuned coordinate_search(const Eigen::VectorXd& start, const CostsOf& costs, bool finer, const std::atomic<bool>* stop,
                        int most_sweeps) {
  constexpr double kWorthIt = 1e-3;
  Tuned best{start, costs({start}).front(), 1};
  const auto stopped = [&] { return stop != nullptr && stop->load(); };
  for (const double step : {1.0, 0.5, 0.25}) {
    if (finer && step == 1.0) continue;
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      const double before = best.cost;
      for (Eigen::Index i = 0; i < start.size() && !stopped(); ++i) {
        std::vector<Eigen::VectorXd> points(2, best.x);
        points[0][i] += step;
        points[1][i] -= step;
        const std::vector<double> found = costs(points);
        best.evaluations += 2;
        for (std::size_t k = 0; k < 2; ++k)
          if (found[k] < best.cost || !(best.cost == best.cost)) {
            best.cost = found[k];
            best.x = points[k];
          }
      }
      if (stopped() || !(best.cost < (1.0 - kWorthIt) * before)) break;
    }
  }
  return best;
}

}  // namespace nlo::trainer
