// SPDX-License-Identifier: MIT
// Integrals over time of an input that is known at samples and held between them. They are exact at any time.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "trainer/config/choices.h"

namespace nlo::trainer {

/// r-fold integral of a held input, in sample periods. It is known at all times from the values at samples.
class HeldIntegral {
 public:
  HeldIntegral(const Eigen::VectorXd& u, Hold hold)
      : u_(u.array() - u.mean()), hold_(hold), once_(u.size()), twice_(u.size()) {
    once_[0] = twice_[0] = 0.0;
    for (Eigen::Index k = 0; k + 1 < u.size(); ++k) {
      once_[k + 1] = once_[k] + part(k, 1.0, 1);
      twice_[k + 1] = twice_[k] + once_[k] + part(k, 1.0, 2);
    }
  }

  /// Returns the integral at time t [samples]. Before the first and after the last sample the input keeps its value.
  double at(double t, int order) const {
    const auto last = static_cast<double>(u_.size() - 2);
    const double whole = std::clamp(std::floor(t), 0.0, last), rest = t - whole;
    const auto k = static_cast<Eigen::Index>(whole);
    if (order == 0) return hold_ == Hold::kZeroOrder ? u_[rest > 0.0 ? k + 1 : k] : u_[k] + rest * (u_[k + 1] - u_[k]);
    return order == 1 ? once_[k] + part(k, rest, 1) : twice_[k] + once_[k] * rest + part(k, rest, 2);
  }

 private:
  /// Integrates from sample k over c samples. zero_order: u(k + 1) has acted since sample k.
  double part(Eigen::Index k, double c, int order) const {
    const double from = u_[k], to = u_[k + 1];
    if (hold_ == Hold::kZeroOrder) return order == 1 ? c * to : 0.5 * c * c * to;
    const double slope = to - from;
    return order == 1 ? c * from + 0.5 * c * c * slope : c * c * (0.5 * from + c * slope / 6.0);
  }

  Eigen::VectorXd u_;
  Hold hold_;
  Eigen::VectorXd once_, twice_;
};

}  // namespace nlo::trainer
