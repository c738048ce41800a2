// SPDX-License-Identifier: MIT
#include "trainer/prove/reachable_latent.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/replay/replay_run.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kForgotten = 1e-9;  // once the memory of a mode is smaller than this, one number bounds the older past
constexpr std::int64_t kMostSteps = 1 << 22;

/// The effect of one reading on a mode.
struct ReachReading {
  Complex b0, b1, steady;
  double centre = 0.0, radius = 0.0;  ///< for a reading that wraps: 0 and half a turn
  bool turns = false;
};

struct ReachMode {
  Index row = 0, rows = 1;
  Complex a_minus_1, initial;
  bool starts_steady = false;
  std::vector<ReachReading> readings;

  Complex factor() const { return 1.0 + a_minus_1; }
};

std::vector<ReachMode> reach_modes(const codegen::Model& m) {
  const codegen::LinearLatent& latent = *codegen::linear_latent(m);
  const codegen::StepMatrices step = codegen::latent_step(m, m.sample_period_s);
  const Eigen::MatrixXd gain = codegen::steady_gain(m);
  const codegen::FlownRanges flown = codegen::flown_ranges(m);
  const VectorXd &low = flown.kept_min, &high = flown.kept_max;
  std::vector<ReachMode> modes;
  for (Index r = 0; r < m.nz();) {
    const bool pair = r < 2 * latent.pairs;
    const auto complex = [&](const auto& rows, Index column) {
      return Complex{rows(r, column), pair ? rows(r + 1, column) : 0.0};
    };
    ReachMode mode{r, pair ? 2 : 1, complex(step.a_minus_1, 0), complex(m.initial_latent, 0), latent.starts_steady, {}};
    for (Index j = 0; j < m.nr(); ++j) {
      ReachReading reading{complex(step.b0, j), complex(step.b1, j), complex(gain, j)};
      // An input with zero-order hold acts with its newest value during the whole step.
      if (m.input_hold == Hold::kZeroOrder && j >= m.ny() && j < m.ny() + m.nu()) {
        reading.b1 += reading.b0;
        reading.b0 = 0.0;
      }
      reading.turns = flown.wrap(j) > 0.0;
      if (reading.turns) {
        reading.radius = 0.5 * flown.wrap(j);
      } else {
        reading.centre = 0.5 * (low(j) + high(j));
        reading.radius = upward(std::max(high(j) - reading.centre, reading.centre - low(j)), 1);
      }
      mode.readings.push_back(reading);
    }
    r += mode.rows;
    modes.push_back(std::move(mode));
  }
  return modes;
}

/// Bounds of |real part| and |imaginary part| of a complex number.
struct Parts {
  double re = 0.0, im = 0.0;

  Parts& operator+=(const Parts& other) {
    re += other.re;
    im += other.im;
    return *this;
  }
  friend Parts operator+(Parts a, const Parts& b) { return a += b; }
  friend Parts operator*(double s, const Parts& p) { return {s * p.re, s * p.im}; }
};
Parts sizes(Complex c) {
  return {std::abs(c.real()), std::abs(c.imag())};
}
Parts both(double size) {
  return {size, size};
}

/// Widens rows mode.row... of `hull` to middle +- radius, including the rounding of `sums` terms.
void include(const ReachMode& mode, Complex middle, const Parts& radius, double sums, LatentHull& hull) {
  const double middles[] = {middle.real(), middle.imag()}, radii[] = {radius.re, radius.im};
  for (Index i = 0; i < mode.rows; ++i) {
    const double reach = upward(radii[i] + gamma(8) * std::abs(middles[i]), sums);
    hull.low(mode.row + i) = std::min(hull.low(mode.row + i), middles[i] - reach);
    hull.high(mode.row + i) = std::max(hull.high(mode.row + i), middles[i] + reach);
  }
}

void add_reach(const ReachMode& mode, LatentHull& hull) {
  const Complex factor = mode.factor();
  const double size = upward(std::abs(factor), 4);
  if (!(size < 1.0)) {
    hull.low.segment(mode.row, mode.rows).setConstant(-std::numeric_limits<double>::infinity());
    hull.high.segment(mode.row, mode.rows).setConstant(std::numeric_limits<double>::infinity());
    return;
  }
  // z is computed relative to its equilibrium `rest` for y_j = c_j. The rounding error of `rest` acts as a small
  // constant input.
  Complex rest = 0.0;
  double all = std::abs(mode.initial), off = 0.0;
  Parts fixed, angles;  // effects that depend on no earlier sample: of y_k, and of an angle itself
  for (const ReachReading& r : mode.readings) {
    rest += r.centre * r.steady;
    const double reach = std::abs(r.centre) + r.radius;
    off += (std::abs(mode.a_minus_1 * r.steady + r.b0 + r.b1) +
            gamma(32) * (std::abs(mode.a_minus_1) * std::abs(r.steady) + std::abs(r.b0) + std::abs(r.b1))) *
           reach;
    all += (std::abs(r.steady) + std::abs(r.b0) + std::abs(r.b1)) * reach;
    (r.turns ? angles : fixed) += r.radius * sizes(r.turns ? r.steady : r.b1);
  }
  // The effect of the reading m steps ago is |factor^(m-1) (B0 + factor B1)| r. For an angle it is |factor^m (S - B1)|
  // times half a turn.
  const double steps_needed = std::log(kForgotten) / std::log(size);
  const auto steps = static_cast<std::int64_t>(std::clamp(steps_needed, 8.0, static_cast<double>(kMostSteps)));
  const double lasting = upward(off / (1.0 - size), 4);
  const Complex apart = mode.initial + (mode.starts_steady ? Complex(0.0) : -rest);
  Complex power = 1.0;  // factor^k
  Parts past;
  {
    Parts first = angles;
    for (const ReachReading& r : mode.readings)
      first += r.radius * sizes(!r.turns && mode.starts_steady ? r.steady : 0.0);
    include(mode, rest + apart, first + both(lasting), 8.0 * static_cast<double>(mode.readings.size()), hull);
  }
  const auto sums = [&](std::int64_t k) {
    return static_cast<double>(2 * k + 16) * static_cast<double>(mode.readings.size() + 1);
  };
  for (std::int64_t k = 1; k <= steps; ++k) {
    const Complex before = power;  // factor^(k-1)
    power *= factor;
    const double rounding = gamma(8 * k + 32) * std::abs(before);
    Parts start;
    for (const ReachReading& r : mode.readings) {
      if (r.turns) {
        past += r.radius * (sizes(before * (r.steady - r.b1)) + both(rounding * (std::abs(r.steady) + std::abs(r.b1))));
        if (!mode.starts_steady) start += r.radius * sizes(power * r.steady);
      } else {
        start += r.radius * sizes(before * r.b0 + (mode.starts_steady ? power * r.steady : Complex(0.0)));
      }
    }
    const Parts reach = fixed + angles + past + start + both(lasting + rounding * all);
    include(mode, rest + power * apart, reach, sums(k), hull);
    for (const ReachReading& r : mode.readings)
      if (!r.turns)
        past +=
            r.radius * (sizes(before * (r.b0 + factor * r.b1)) + both(rounding * (std::abs(r.b0) + std::abs(r.b1))));
  }
  // Bounds the effect of all older readings.
  double older = 0.0;
  for (const ReachReading& r : mode.readings)
    older += r.radius * (std::abs(r.steady) + 2.0 * (std::abs(r.b0) + std::abs(r.b1)));
  const double left = upward(std::abs(power) * (1.0 + gamma(8 * steps + 32)) * (all + older / (1.0 - size)), 32);
  include(mode, rest, fixed + angles + past + both(lasting + left), sums(steps), hull);
}

}  // namespace

bool moves_linearly(const codegen::Model& model) {
  return codegen::linear_latent(model) != nullptr && (model.nu() == 0 || !model.inputs.empty());
}

LatentHull reachable_latent(const codegen::Model& model) {
  LatentHull hull{VectorXd::Constant(model.nz(), std::numeric_limits<double>::infinity()),
                  VectorXd::Constant(model.nz(), -std::numeric_limits<double>::infinity())};
  for (const ReachMode& mode : reach_modes(model)) add_reach(mode, hull);
  return hull;
}

LatentHull reached_latent(const codegen::Model& model) {
  constexpr std::int64_t kAllSteps = 400000;
  constexpr double kInside = 1.0 - 1e-9;  // stays below half a turn, where the sign of a change is ambiguous
  LatentHull hull{VectorXd::Constant(model.nz(), std::numeric_limits<double>::infinity()),
                  VectorXd::Constant(model.nz(), -std::numeric_limits<double>::infinity())};
  const Eigen::MatrixXd gain = codegen::steady_gain(model);
  const std::int64_t most = std::max<std::int64_t>(64, kAllSteps / (2 * model.nz()));
  codegen::ReferenceObserver<double> observer(model);
  for (const ReachMode& mode : reach_modes(model)) {
    const double size = std::abs(mode.factor());
    const std::int64_t wanted = size < 1.0 ? static_cast<std::int64_t>(std::log(1e-4) / std::log(size)) + 8 : most;
    const std::int64_t steps = std::min(wanted, most);
    for (Index part = 0; part < mode.rows; ++part) {
      const auto sign = [&](Complex c) { return (part == 0 ? c.real() : c.imag()) < 0.0 ? -1.0 : 1.0; };
      for (const double side : {-1.0, 1.0}) {
        observer.reset();
        VectorXd y = VectorXd::Zero(static_cast<Index>(mode.readings.size()));
        for (std::int64_t k = 0; k <= steps; ++k) {
          const std::int64_t past = steps - k;
          const Complex power = past == 0 ? 1.0 : std::pow(mode.factor(), static_cast<double>(past));
          for (Index j = 0; j < y.size(); ++j) {
            const ReachReading& r = mode.readings[static_cast<std::size_t>(j)];
            if (r.turns) {  // the change y - y' in the step from k - 1, then S y itself
              const double move = k == 0 ? 1.0 : -sign(power * (r.steady - r.b1));
              y(j) += side * move * r.radius * kInside;
            } else {
              const Complex weight = past == 0 ? r.b1 : power / mode.factor() * (r.b0 + mode.factor() * r.b1);
              y(j) = r.centre + side * sign(weight) * r.radius;
            }
          }
          VectorXd measured = y;
          for (Index j = 0; j < y.size(); ++j) {
            const double turn = 2.0 * mode.readings[static_cast<std::size_t>(j)].radius;
            if (mode.readings[static_cast<std::size_t>(j)].turns) measured(j) -= turn * std::round(y(j) / turn);
          }
          observer.step(measured.head(model.ny()), measured.segment(model.ny(), model.nu()));
          const VectorXd z = observer.latent() - gain * codegen::turns_in(model, observer.output());
          hull.low = hull.low.cwiseMin(z);
          hull.high = hull.high.cwiseMax(z);
        }
      }
    }
  }
  return hull;
}

}  // namespace nlo::trainer
