// SPDX-License-Identifier: MIT
// The KKL latent system (16), z' = D z + F y, as a differential equation, as in the paper. Tests compare the filter of
// gradients/sensitivity/linear_latent.h with it. theta: parameters of the eigenvalues, as in that file.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "trainer/gradients/sensitivity/ode_dynamics.h"

namespace nlo::trainer {

template <class Scalar>
class KklLanes final : public OdeDynamics<Scalar> {
 public:
  /// eigenvalues: n_z initial eigenvalues. Those of clocks do not change.
  KklLanes(LatentShape shape, std::vector<double> eigenvalues, int outputs)
      : OdeDynamics<Scalar>(shape.rows, outputs, shape.learned),
        shape_(std::move(shape)),
        eigenvalues_(std::move(eigenvalues)),
        gradient_(eigenvalues_.size()) {
    for (auto& slot : slots_) {
      slot.z.resize(eigenvalues_.size() * kGroup);
      slot.y.resize(static_cast<std::size_t>(outputs) * kGroup);
    }
  }

  void prepare(const Scalar* theta) override {
    for (int r = 0; r < shape_.learned; ++r) {
      const auto i = static_cast<std::size_t>(r);
      eigenvalues_[i] = (is_imaginary(r) ? 1.0 : -1.0) * std::exp(static_cast<double>(theta[r]));
    }
  }

  void start(Scalar* z) const override {
    for (const Mode& mode : shape_.modes) {
      for (int r = mode.row; r < mode.row + (mode.pair ? 2 : 1); ++r)
        std::fill_n(z + r * kGroup, kGroup, Scalar(mode.reading < 0 ? 1 : 0));
    }
  }

  void derivative(int slot, const Scalar* z, const Scalar* y, Scalar* dz) override {
    Slot& kept = slots_[static_cast<std::size_t>(slot)];
    std::copy_n(z, kept.z.size(), kept.z.data());
    std::copy_n(y, kept.y.size(), kept.y.data());
    for (const Mode& mode : shape_.modes) {
      const std::complex<double> lambda = eigenvalue(mode), f = injection_of(shape_.injection, mode, lambda);
      for (int l = 0; l < kGroup; ++l) {
        const int at = mode.row * kGroup + l;
        const Scalar driven = mode.reading < 0 ? Scalar(0) : y[mode.reading * kGroup + l];
        if (mode.pair) {
          dz[at] = re(lambda) * z[at] - im(lambda) * z[at + kGroup] + re(f) * driven;
          dz[at + kGroup] = im(lambda) * z[at] + re(lambda) * z[at + kGroup] + im(f) * driven;
        } else {
          dz[at] = re(lambda) * z[at] + re(f) * driven;
        }
      }
    }
  }

  void pull_back(int slot, const Scalar* p, Scalar* cotangent_z) override {
    const Slot& kept = slots_[static_cast<std::size_t>(slot)];
    // dF/dlambda of a unit-gain row is -1, else 0: F = -lambda.
    const Scalar df = shape_.injection == Injection::kUnitGain ? Scalar(-1) : Scalar(0);
    for (const Mode& mode : shape_.modes) {
      const std::complex<double> lambda = eigenvalue(mode);
      Scalar total_re(0), total_im(0);
      for (int l = 0; l < kGroup; ++l) {
        const int at = mode.row * kGroup + l;
        const auto i = static_cast<std::size_t>(at);
        const Scalar z = kept.z[i];
        const Scalar y =
            mode.reading < 0 ? Scalar(0) : df * kept.y[static_cast<std::size_t>(mode.reading * kGroup + l)];
        if (mode.pair) {
          const Scalar z_im = kept.z[i + kGroup];
          cotangent_z[at] = re(lambda) * p[at] + im(lambda) * p[at + kGroup];
          cotangent_z[at + kGroup] = re(lambda) * p[at + kGroup] - im(lambda) * p[at];
          total_re += p[at] * (z + y) + p[at + kGroup] * z_im;
          total_im += p[at + kGroup] * (z + y) - p[at] * z_im;
        } else {
          cotangent_z[at] = re(lambda) * p[at];
          total_re += p[at] * (z + y);
        }
      }
      const auto row = static_cast<std::size_t>(mode.row);
      gradient_[row] += total_re * re(lambda);  // d lambda / d theta = lambda for either of -exp and exp
      if (mode.pair) gradient_[row + 1] += total_im * im(lambda);
    }
  }

  void clear_gradient() override { std::fill(gradient_.begin(), gradient_.end(), Scalar(0)); }
  void gradient(Scalar* out) const override { std::copy_n(gradient_.begin(), this->parameters(), out); }

 private:
  struct Slot {
    std::vector<Scalar> z, y;
  };
  static Scalar re(std::complex<double> c) { return static_cast<Scalar>(c.real()); }
  static Scalar im(std::complex<double> c) { return static_cast<Scalar>(c.imag()); }
  std::complex<double> eigenvalue(const Mode& mode) const {
    const auto row = static_cast<std::size_t>(mode.row);
    return {eigenvalues_[row], mode.pair ? eigenvalues_[row + 1] : 0.0};
  }
  bool is_imaginary(int row) const {
    for (const Mode& mode : shape_.modes)
      if (mode.pair && mode.row + 1 == row) return true;
    return false;
  }

  LatentShape shape_;
  std::vector<double> eigenvalues_;
  std::array<Slot, OdeDynamics<Scalar>::kSlots> slots_;
  std::vector<Scalar> gradient_;
};

}  // namespace nlo::trainer
