// SPDX-License-Identifier: MIT
#include "trainer/prove/taylor_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using codegen::Function;
using codegen::Interval;

constexpr std::size_t kProducts = 84;

/// Indices of the products t^power, ordered by rising total degree.
struct Places {
  std::array<TaylorModel::Powers, kProducts> powers{};
  std::array<std::array<std::array<std::size_t, TaylorModel::kOrder + 1>, TaylorModel::kOrder + 1>,
             TaylorModel::kOrder + 1>
      place{};
  std::array<int, kProducts> degree{};

  constexpr Places() {
    std::size_t next = 0;
    for (int total = 0; total <= TaylorModel::kOrder; ++total)
      for (int i = total; i >= 0; --i)
        for (int j = total - i; j >= 0; --j) {
          const int k = total - i - j;
          powers[next] = {i, j, k};
          degree[next] = total;
          place[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)][static_cast<std::size_t>(k)] = next++;
        }
  }

  constexpr std::size_t of(const TaylorModel::Powers& power) const {
    return place[static_cast<std::size_t>(power[0])][static_cast<std::size_t>(power[1])]
                [static_cast<std::size_t>(power[2])];
  }
};
constexpr Places kPlaces;

constexpr double kUp = 1.0 + 64.0 * kUnit;  // covers the rounding of a few sums and products of nonnegative numbers

/// Returns Taylor's series of a function at every point of x: term k is g^(k)(x) / k!.
template <class Series>
Series series_of(Function function, const Interval& x) {
  Series s;
  const auto count = static_cast<int>(s.size());
  const auto at = [&](int k) -> Interval& { return s[static_cast<std::size_t>(k)]; };
  switch (function) {
    case Function::kSine:
    case Function::kCosine: {
      const Interval sine = value_of(Function::kSine, x), cosine = value_of(Function::kCosine, x);
      Interval factor = 1.0;
      for (int k = 0; k < count; ++k) {
        const int turn = (k + (function == Function::kCosine ? 1 : 0)) % 4;
        const Interval value = turn % 2 == 0 ? sine : cosine;
        at(k) = factor * (turn < 2 ? value : Interval(0.0) - value);
        factor = factor / Interval(k + 1.0);
      }
      return s;
    }
    case Function::kExponential:
      at(0) = value_of(function, x);
      for (int k = 1; k < count; ++k) at(k) = at(k - 1) / Interval(1.0 * k);
      return s;
    case Function::kLogarithm:
      at(0) = value_of(function, x);
      at(1) = Interval(1.0) / x;
      for (int k = 2; k < count; ++k) at(k) = Interval(0.0) - at(k - 1) * Interval(k - 1.0) / (Interval(1.0 * k) * x);
      return s;
    case Function::kTanh:  // g' = 1 - g^2
      at(0) = value_of(function, x);
      for (int k = 0; k + 1 < count; ++k) {
        Interval sum = k == 0 ? 1.0 : 0.0;
        for (int i = 0; i <= k; ++i) sum = sum - at(i) * at(k - i);
        at(k + 1) = sum / Interval(k + 1.0);
      }
      return s;
    case Function::kArcTangent: {  // (1 + x^2) g' = 1
      at(0) = value_of(function, x);
      const Interval below = Interval(1.0) + square(x);
      for (int k = 0; k + 1 < count; ++k) {
        Interval sum = k == 0 ? 1.0 : 0.0;
        if (k >= 1) sum = sum - Interval(2.0 * k) * x * at(k);
        if (k >= 2) sum = sum - Interval(k - 1.0) * at(k - 1);
        at(k + 1) = sum / (Interval(k + 1.0) * below);
      }
      return s;
    }
    case Function::kMagnitude:
      s.fill(Interval(0.0));
      at(0) = value_of(function, x);
      at(1) = x.low > 0.0 ? Interval(1.0) : x.high < 0.0 ? Interval(-1.0) : Interval(-1.0, 1.0);
      if (x.low <= 0.0 && x.high >= 0.0) s.fill(Interval::any());
      return s;
    default:  // slopes of sqrt and sign are unbounded at 0
      s.fill(Interval::any());
      return s;
  }
}

}  // namespace

TaylorModel TaylorModel::variable(std::size_t index, double centre, double radius) {
  TaylorModel x(centre);
  Powers power{};
  power[index] = 1;
  x.add(power, radius);
  return x;
}

void TaylorModel::add(const Powers& power, double c) {
  if (power[0] + power[1] + power[2] > kOrder) {
    remainder_ = (remainder_ + std::abs(c)) * kUp;
    return;
  }
  double& own = coefficients_[kPlaces.of(power)];
  own += c;
  remainder_ += 2.0 * kUnit * std::abs(own);
}

double TaylorModel::size() const {
  double sum = 0.0;
  for (const double c : coefficients_) sum += std::abs(c);
  return sum * (1.0 + 2.0 * kProducts * kUnit);
}

double TaylorModel::most() const {
  const double most = (size() + remainder_) * kUp;
  return std::isnan(most) ? std::numeric_limits<double>::infinity() : most;
}

TaylorModel operator+(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel sum = a;
  for (std::size_t i = 0; i < kProducts; ++i) sum.coefficients_[i] += b.coefficients_[i];
  sum.remainder_ = (a.remainder_ + b.remainder_ + kUnit * sum.size()) * kUp;
  return sum;
}

TaylorModel operator-(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel negative = b;
  for (double& c : negative.coefficients_) c = -c;
  return a + negative;
}

TaylorModel operator*(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel product;
  double beyond = 0.0;
  for (std::size_t i = 0; i < kProducts; ++i) {
    const double c = a.coefficients_[i];
    if (c == 0.0) continue;
    const TaylorModel::Powers& p = kPlaces.powers[i];
    for (std::size_t j = 0; j < kProducts; ++j) {
      const double d = b.coefficients_[j];
      if (d == 0.0) continue;
      if (kPlaces.degree[i] + kPlaces.degree[j] > TaylorModel::kOrder) {
        beyond += std::abs(c * d);
        continue;
      }
      const TaylorModel::Powers& q = kPlaces.powers[j];
      product.coefficients_[kPlaces.of({p[0] + q[0], p[1] + q[1], p[2] + q[2]})] += c * d;
    }
  }
  const double of_a = a.size(), of_b = b.size();
  product.remainder_ =
      (beyond + of_a * b.remainder_ + a.remainder_ * (of_b + b.remainder_) + gamma(2 * kProducts) * of_a * of_b) *
      (1.0 + gamma(kProducts * kProducts));
  return product;
}

template <class SeriesOf>
TaylorModel TaylorModel::composed(const SeriesOf& series_of) const {
  TaylorModel rest = *this;  // x minus its value at the centre
  rest.coefficients_[0] = 0.0;
  const double by = rest.most(), at = coefficients_[0];
  const Series series = series_of(Interval(at)), everywhere = series_of(Interval(at) + Interval(-by, by));
  const double last = std::max(std::abs(everywhere.back().low), std::abs(everywhere.back().high));
  TaylorModel result;
  for (int k = kOrder; k >= 0; --k) {  // Horner's scheme
    const Interval& term = series[static_cast<std::size_t>(k)];
    const double middle = 0.5 * (term.low + term.high);
    result = result * rest + TaylorModel(middle);
    result.remainder_ += std::max(term.high - middle, middle - term.low) * kUp;
  }
  double power = 1.0;
  for (int k = 0; k <= kOrder; ++k) power *= by;
  result.remainder_ = (result.remainder_ + last * power) * kUp;
  if (std::isnan(result.remainder_)) result.remainder_ = std::numeric_limits<double>::infinity();
  return result;
}

TaylorModel operator/(const TaylorModel& a, const TaylorModel& b) {
  return a * b.composed([](const Interval& x) {
    TaylorModel::Series s;
    s[0] = Interval(1.0) / x;
    for (std::size_t k = 1; k < s.size(); ++k) s[k] = Interval(0.0) - s[k - 1] / x;
    return s;
  });
}

TaylorModel value_of(Function function, const TaylorModel& x) {
  return x.composed([function](const Interval& at) { return series_of<TaylorModel::Series>(function, at); });
}

/// Returns (a + b - |a - b|) / 2.
TaylorModel minimum_of(const TaylorModel& a, const TaylorModel& b) {
  return (a + b - value_of(Function::kMagnitude, a - b)) * TaylorModel(0.5);
}
TaylorModel maximum_of(const TaylorModel& a, const TaylorModel& b) {
  return (a + b + value_of(Function::kMagnitude, a - b)) * TaylorModel(0.5);
}

}  // namespace nlo::trainer
