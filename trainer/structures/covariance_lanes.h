// SPDX-License-Identifier: MIT
// The measurement update of the covariance (nlo/covariance.h) for eight trajectories side by side, and its pullback.
#pragma once

#include <nlo/covariance.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "trainer/structures/lane_numbers.h"

namespace nlo::trainer {

/// Values of one sample, or their cotangents.
template <class Scalar>
struct Measured {
  using L = Lanes<Scalar>;
  std::vector<L> p;                  ///< triangle
  std::vector<L> slopes;             ///< n_y x n_x
  std::vector<L> innovations, r, q;  ///< n_y, n_y, n_x
  std::vector<L> arrived;            ///< n_y: 1 where the output was measured, else 0
  std::vector<L> change;             ///< n_x, x - x-

  Measured(int nx, int ny)
      : p(static_cast<std::size_t>(triangle_size(nx))),
        slopes(static_cast<std::size_t>(nx * ny)),
        innovations(static_cast<std::size_t>(ny)),
        r(innovations),
        q(static_cast<std::size_t>(nx)),
        arrived(static_cast<std::size_t>(ny), in_lanes<L>(1.0)),
        change(q) {}
};

template <class Scalar>
class CovarianceUpdate {
 public:
  using L = Lanes<Scalar>;

  CovarianceUpdate(int nx, int ny)
      : nx_(nx), ny_(ny), taken_(static_cast<std::size_t>(ny), Taken(nx)), to_ph_(static_cast<std::size_t>(nx)) {}

  /// Replaces p before the measurement by p after it, and fills `change`.
  void forward(Measured<Scalar>& of) {
    for (int i = 0; i < nx_; ++i) {
      element(of.p, i, i) += of.q[at(i)];
      of.change[at(i)] = L{};
    }
    for (int j = 0; j < ny_; ++j) {
      const L* h = of.slopes.data() + static_cast<std::ptrdiff_t>(j) * nx_;
      Taken& now = taken_[at(j)];
      now.p = of.p;
      now.change = of.change;
      L spread{};
      now.rest = of.innovations[at(j)];
      for (int i = 0; i < nx_; ++i) {
        L sum{};
        for (int k = 0; k < nx_; ++k) sum += element(of.p, i, k) * h[k];
        now.ph[at(i)] = sum;
      }
      for (int i = 0; i < nx_; ++i) {
        spread += h[i] * now.ph[at(i)];
        now.rest -= h[i] * of.change[at(i)];
      }
      now.positive = spread < L{} ? L{} : in_lanes<L>(1.0 + static_cast<double>(kLeastNoise));
      now.share = of.arrived[at(j)] / (now.positive * spread + of.r[at(j)]);
      for (int i = 0; i < nx_; ++i) {
        const L gain = now.ph[at(i)] * now.share;
        of.change[at(i)] += gain * now.rest;
        for (int k = i; k < nx_; ++k) element(of.p, i, k) -= gain * now.ph[at(k)];
      }
    }
  }

  /// Call it after forward(of). Replaces the cotangents of p and change in `to` by the cotangent of p before the
  /// measurement, and fills the other cotangents.
  void backward(const Measured<Scalar>& of, Measured<Scalar>& to) {
    std::fill(to.slopes.begin(), to.slopes.end(), L{});
    for (int j = ny_; j-- > 0;) {
      const L* h = of.slopes.data() + static_cast<std::ptrdiff_t>(j) * nx_;
      L* to_h = to.slopes.data() + static_cast<std::ptrdiff_t>(j) * nx_;
      const Taken& now = taken_[at(j)];
      std::fill(to_ph_.begin(), to_ph_.end(), L{});
      L to_rest{}, to_share{};
      for (int i = 0; i < nx_; ++i) {
        const L gain = now.ph[at(i)] * now.share;
        to_rest += to.change[at(i)] * gain;
        L to_gain = to.change[at(i)] * now.rest;
        for (int k = i; k < nx_; ++k) {
          const L& to_p = element(to.p, i, k);
          to_gain -= to_p * now.ph[at(k)];
          to_ph_[at(k)] -= to_p * gain;
        }
        to_ph_[at(i)] += to_gain * now.share;
        to_share += to_gain * now.ph[at(i)];
      }
      const L to_sum = -to_share * now.share * now.share;
      to.r[at(j)] = to_sum;
      to.innovations[at(j)] = to_rest;
      const L to_spread = to_sum * now.positive;
      for (int i = 0; i < nx_; ++i) {
        to_ph_[at(i)] += to_spread * h[i];
        to_h[i] += to_spread * now.ph[at(i)] - to_rest * now.change[at(i)];
        to.change[at(i)] -= to_rest * h[i];
      }
      for (int i = 0; i < nx_; ++i)
        for (int k = 0; k < nx_; ++k) {
          element(to.p, i, k) += to_ph_[at(i)] * h[k];
          to_h[k] += to_ph_[at(i)] * element(now.p, i, k);
        }
    }
    for (int i = 0; i < nx_; ++i) to.q[at(i)] = element(to.p, i, i);
  }

 private:
  /// Values of the update by one output that the pullback needs.
  struct Taken {
    std::vector<L> p, change, ph;
    L rest, share, positive;  ///< positive: dS / d(h' P h)

    explicit Taken(int nx) : ph(static_cast<std::size_t>(nx)) {}
  };

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  L& element(std::vector<L>& p, int i, int j) const { return p[at(in_triangle(nx_, i, j))]; }
  const L& element(const std::vector<L>& p, int i, int j) const { return p[at(in_triangle(nx_, i, j))]; }

  int nx_, ny_;
  std::vector<Taken> taken_;
  std::vector<L> to_ph_;
};

}  // namespace nlo::trainer
