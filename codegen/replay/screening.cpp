// SPDX-License-Identifier: MIT
#include "codegen/replay/screening.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "codegen/fold/fold.h"

namespace nlo::codegen {

Screening::Screening(const Model& model) : model_(model), stale_after_(stale_after(model)) {
  reset();
}

void Screening::reset() {
  y_ = Eigen::VectorXd::Zero(model_.ny());
  u_ = Eigen::VectorXd::Zero(model_.nu());
  status_ = StepStatus::kOk;
  held_ = 0;
  started_ = false;
}

bool Screening::take(const Eigen::VectorXd& y, const Eigen::VectorXd& u, bool wrapped) {
  Eigen::VectorXd good_y = y, good_u = u;
  bool held = !u.allFinite(), clamped = false;
  for (int j = 0; j < model_.ny(); ++j) {
    const double wrap = model_.outputs[static_cast<std::size_t>(j)].wrap;
    const double low = model_.output_min(j), high = model_.output_max(j);
    const bool outside = y(j) < low || y(j) > high;
    if (wrap == 0.0) {
      if (std::isfinite(y(j))) good_y(j) = std::clamp(y(j), low, high);
      clamped = clamped || outside;
    } else if (wrapped) {
      if (outside) good_y(j) = std::nan("");
      good_y(j) -= wrap * std::round((good_y(j) - y_(j)) / wrap);
    }
    if (std::isfinite(good_y(j))) continue;
    held = true;
    if (started_) good_y(j) = y_(j);
  }
  for (Eigen::Index i = 0; i < good_u.size(); ++i)
    if (!std::isfinite(good_u(i)) && started_) good_u(i) = u_(i);

  held_ = held ? held_ + 1 : 0;
  status_ = held_ >= stale_after_ ? StepStatus::kStale
            : held                ? StepStatus::kHeld
            : clamped             ? StepStatus::kClamped
                                  : StepStatus::kOk;
  if (!good_y.allFinite() || !good_u.allFinite()) return false;
  y_ = good_y;
  u_ = good_u;
  started_ = true;
  return true;
}

}  // namespace nlo::codegen
