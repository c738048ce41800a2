// SPDX-License-Identifier: MIT
#include "trainer/data/delay_search.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/data/held_integral.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEarliest = -8.0;       // smallest delay [samples]: an input may be logged after it acted
constexpr double kLeastExplained = 0.3;  // an input that explains less than this share of the residual is not resolved
// Largest residual, as a share of the variance. Above it the regression lacks a quantity that is larger than u, and in
// a closed loop u may depend on this quantity.
constexpr double kMostUnexplained = 0.4;

/// One regression: delta_m^r of quantity q.
struct Choice {
  Index quantity;
  int degree, stride;

  Index width() const { return std::max(degree, 1) * stride; }
};

/// Returns f(k) minus the mean of the values one width before and one width after. This removes slow parts from every
/// term in the same way.
template <class F>
double passed(const Choice& choice, Index k, const F& f) {
  return f(k) - 0.5 * (f(k - choice.width()) + f(k + choice.width()));
}

template <class At>
double difference(const Choice& choice, const At& at) {
  const int m = choice.stride;
  if (choice.degree == 0) return at(0);
  return choice.degree == 1 ? at(m) - at(0) : at(2 * m) - 2.0 * at(m) + at(0);
}

class Regression {
 public:
  Regression(const std::vector<DelayRun>& runs, const std::vector<double>& angles,
             const std::vector<std::vector<HeldIntegral>>& inputs, const Choice& choice, double longest)
      : runs_(runs), inputs_(inputs), choice_(choice), margin_(static_cast<Index>(std::ceil(longest))) {
    for (const DelayRun& run : runs) rows_ += rows_of(run);
    const Index quantities = runs.front().measured.rows();
    if (rows_ < 20 * (1 + 3 * quantities)) {
      rows_ = 0;
      return;
    }
    VectorXd target(rows_);
    MatrixXd features(rows_, 1 + 3 * quantities);
    Index row = 0;
    for (const DelayRun& run : runs)
      for (Index k = first(); k < first() + rows_of(run); ++k, ++row) {
        target[row] = passed(choice, k, [&](Index at) {
          return difference(choice, [&](Index m) { return run.measured(choice.quantity, at + m); });
        });
        features(row, 0) = 1.0;
        for (Index j = 1; j < features.cols(); ++j)
          features(row, j) = passed(choice, k, [&](Index at) { return feature(run, angles, at, j - 1); });
      }
    for (Index j = 0; j < features.cols(); ++j)
      if (const double norm = features.col(j).norm(); norm > 0.0) features.col(j) /= norm;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(features);
    qr.setThreshold(1e-8);
    basis_ = qr.householderQ() * MatrixXd::Identity(rows_, qr.rank());
    variance_ = (target.array() - target.mean()).square().sum();
    target_ = without_basis(target);
  }

  bool usable() const { return rows_ > 0 && variance_ > 0.0; }
  const Choice& choice() const { return choice_; }

  /// Returns the part of input j, held and delayed by d samples, that the features do not explain.
  VectorXd column(std::size_t j, double d) const {
    VectorXd values(rows_);
    Index row = 0;
    for (std::size_t i = 0; i < runs_.size(); ++i)
      for (Index k = first(); k < first() + rows_of(runs_[i]); ++k)
        values[row++] = passed(choice_, k, [&](Index at) {
          return difference(choice_,
                            [&](int m) { return inputs_[i][j].at(static_cast<double>(at + m) - d, choice_.degree); });
        });
    return without_basis(values);
  }

  /// Returns the residual with these columns, as a share of the variance.
  double residual(const std::vector<VectorXd>& columns) const {
    return (target_ - fit(columns, target_).prediction).squaredNorm() / variance_;
  }

  /// Returns the standard deviation of the delay of input j at the minimum [samples]: the error of its score (Newey and
  /// West, because neighbouring residuals are correlated) divided by the curvature. `slope`: d column(j) / d delay.
  double deviation(const std::vector<VectorXd>& columns, std::size_t j, const VectorXd& slope) const {
    const Fit best = fit(columns, target_);
    VectorXd direction = slope * best.weights[static_cast<Index>(j)];
    direction -= fit(columns, direction).prediction;  // removes the part that other weights also explain
    const VectorXd score = (target_ - best.prediction).cwiseProduct(direction);
    const Index lags = std::min<Index>(8 * choice_.width() + 40, rows_ / 4);
    double sum = score.squaredNorm();
    for (Index lag = 1; lag < lags; ++lag) {
      const double share = 1.0 - static_cast<double>(lag) / static_cast<double>(lags);
      sum += 2.0 * share * score.head(rows_ - lag).dot(score.tail(rows_ - lag));
    }
    const double curvature = direction.squaredNorm();
    return curvature > 0.0 ? std::sqrt(std::max(sum, score.squaredNorm())) / curvature
                           : std::numeric_limits<double>::infinity();
  }

 private:
  struct Fit {
    VectorXd weights, prediction;
  };
  Fit fit(const std::vector<VectorXd>& columns, const VectorXd& target) const {
    MatrixXd u(rows_, static_cast<Index>(columns.size()));
    VectorXd norms(u.cols());
    for (Index j = 0; j < u.cols(); ++j) {
      norms[j] = std::max(columns[static_cast<std::size_t>(j)].norm(), 1e-300);
      u.col(j) = columns[static_cast<std::size_t>(j)] / norms[j];
    }
    constexpr double kRidge = 1e-10;
    const MatrixXd gram = u.transpose() * u + kRidge * MatrixXd::Identity(u.cols(), u.cols());
    const VectorXd weights = codegen::solve_symmetric(gram, u.transpose() * target);
    return {weights.cwiseQuotient(norms), u * weights};
  }

  /// Returns a feature of a quantity: its level, its square, or its change over the width; for an angle its sine or
  /// cosine.
  double feature(const DelayRun& run, const std::vector<double>& angles, Index k, Index index) const {
    const Index q = index / 3, w = choice_.width();
    if (choice_.degree == 0) return 0.0;  // if the measured quantity were u itself, a level would explain it
    if (index % 3 == 2) return choice_.degree == 2 ? run.measured(q, k + w) - run.measured(q, k) : 0.0;
    const double level = 0.5 * (run.measured(q, k + w / 2) + run.measured(q, k + (w + 1) / 2));
    const double turn = angles[static_cast<std::size_t>(q)];
    if (turn == 0.0) return index % 3 == 0 ? level : level * level;
    const double phase = 2.0 * std::numbers::pi * level / turn;
    return index % 3 == 0 ? std::sin(phase) : std::cos(phase);
  }

  Index first() const { return margin_ + choice_.width(); }
  Index rows_of(const DelayRun& run) const {
    return std::max<Index>(
        run.measured.cols() - choice_.width() - 2 * choice_.width() - margin_ - static_cast<Index>(-kEarliest), 0);
  }
  VectorXd without_basis(const VectorXd& v) const { return v - basis_ * (basis_.transpose() * v); }

  const std::vector<DelayRun>& runs_;
  const std::vector<std::vector<HeldIntegral>>& inputs_;
  Choice choice_;
  Index margin_, rows_ = 0;
  MatrixXd basis_;
  VectorXd target_;
  double variance_ = 0.0;
};

/// The best delays of one choice: coordinate descent over whole samples, then over quarters, then a parabola.
class Search {
 public:
  Search(const Regression& regression, const std::vector<double>& known, double longest)
      : regression_(regression), known_(known), longest_(longest), delays_(known.size()), columns_(known.size()) {
    std::vector<double> common;  // residuals if all unknown delays are equal; their minimum is near each delay
    for (double d = kEarliest; d <= longest_; d += 1.0) {
      set_unknown(d);
      common.push_back(regression_.residual(columns_));
    }
    set_unknown(kEarliest + static_cast<double>(std::min_element(common.begin(), common.end()) - common.begin()));
    for (int sweep = 0; sweep < 3; ++sweep)
      for (std::size_t j = 0; j < known_.size(); ++j)
        if (std::isnan(known_[j])) scan(j, kEarliest, longest_, 1.0);
    for (int sweep = 0; sweep < 2; ++sweep)
      for (std::size_t j = 0; j < known_.size(); ++j)
        if (std::isnan(known_[j])) scan(j, delays_[j] - 1.0, delays_[j] + 1.0, 0.25);
  }

  /// Returns one delay for each input; known delays are not changed.
  std::vector<FoundDelay> all() const {
    std::vector<VectorXd> undelayed = columns_;
    for (std::size_t j = 0; j < known_.size(); ++j)
      if (std::isnan(known_[j])) undelayed[j] = regression_.column(j, 0.0);
    const double without = regression_.residual(undelayed);
    std::vector<FoundDelay> result;
    for (std::size_t j = 0; j < known_.size(); ++j)
      result.push_back(std::isnan(known_[j]) ? found(j, without) : FoundDelay{.samples = known_[j]});
    return result;
  }

 private:
  double residual() const { return regression_.residual(columns_); }

  FoundDelay found(std::size_t j, double without) const {
    constexpr double kStep = 0.25;
    const double below = residual_at(j, delays_[j] - kStep), middle = residual(),
                 above = residual_at(j, delays_[j] + kStep);
    const double bend = below - 2.0 * middle + above;
    FoundDelay result{.samples = delays_[j],
                      .deviation = std::numeric_limits<double>::infinity(),
                      .without = without,
                      .with = middle,
                      .at_the_end = delays_[j] >= longest_ - 1.0 || delays_[j] <= kEarliest + 1.0};
    std::vector<VectorXd> others = columns_;
    others[j].setZero();
    result.explains = 1.0 - middle / regression_.residual(others);
    if (!(bend > 0.0) || result.explains < kLeastExplained || middle > kMostUnexplained) return result;
    result.samples += std::clamp(0.5 * kStep * (below - above) / bend, -kStep, kStep);
    const VectorXd difference = regression_.column(j, delays_[j] + kStep) - regression_.column(j, delays_[j] - kStep);
    result.deviation = regression_.deviation(columns_, j, difference / (2.0 * kStep));
    return result;
  }

  void set(std::size_t j, double d) {
    delays_[j] = d;
    columns_[j] = regression_.column(j, d);
  }
  void set_unknown(double d) {
    for (std::size_t j = 0; j < known_.size(); ++j) set(j, std::isnan(known_[j]) ? d : known_[j]);
  }
  double residual_at(std::size_t j, double d) const {
    std::vector<VectorXd> columns = columns_;
    columns[j] = regression_.column(j, d);
    return regression_.residual(columns);
  }
  void scan(std::size_t j, double from, double to, double step) {
    double best = residual(), at = delays_[j];
    for (double d = std::max(from, kEarliest); d <= std::min(to, longest_) + 1e-9; d += step)
      if (const double now = residual_at(j, d); now < best) {
        best = now;
        at = d;
      }
    set(j, at);
  }

  const Regression& regression_;
  const std::vector<double>& known_;
  double longest_;
  std::vector<double> delays_;
  std::vector<VectorXd> columns_;
};

}  // namespace

std::vector<FoundDelay> find_delays(const std::vector<DelayRun>& runs, const std::vector<double>& angles,
                                    const std::vector<double>& known, Hold hold, double longest) {
  std::vector<std::vector<HeldIntegral>> inputs;
  for (const DelayRun& run : runs) {
    std::vector<HeldIntegral>& own = inputs.emplace_back();
    for (Index j = 0; j < run.inputs.rows(); ++j) own.emplace_back(run.inputs.row(j).transpose(), hold);
  }
  std::vector<FoundDelay> best(known.size());
  for (FoundDelay& found : best) found.deviation = std::numeric_limits<double>::infinity();
  for (Index q = 0; q < static_cast<Index>(angles.size()); ++q)
    for (const int degree : {0, 1, 2}) {
      std::vector<FoundDelay> finer;  // delays found with half the stride
      for (const int stride : {1, 2, 4, 8, 16, 32, 64}) {
        const Regression regression(runs, angles, inputs, {q, degree, stride}, longest);
        if (!regression.usable()) break;
        std::vector<FoundDelay> found = Search(regression, known, longest).all();
        for (std::size_t j = 0; j < finer.size(); ++j) {
          // A regression that lacks a quantity finds another delay with each stride.
          finer[j].deviation = std::hypot(finer[j].deviation, found[j].samples - finer[j].samples);
          if (finer[j].deviation < best[j].deviation) best[j] = finer[j];
        }
        finer = std::move(found);
      }
    }
  for (std::size_t j = 0; j < known.size(); ++j)
    if (std::isnan(known[j]) && !std::isfinite(best[j].deviation))
      throw codegen::Error(
          "the delay cannot be found, because the logs are too short or an input has no effect on any measurement");
  return best;
}

}  // namespace nlo::trainer
