// SPDX-License-Identifier: MIT
#include "trainer/data/product_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "trainer/data/angle.h"
#include "trainer/data/static_ridge.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRidge = 1e-4;              // relative to the power of each feature
constexpr double kAverages[] = {5.0, 25.0};  // time constants [samples]
constexpr Index kOf = 3;                     // features of each channel: the channel and its two averages
constexpr double kLeastGain = 0.05;
constexpr double kNothing = 0.005;            // errors below this share of a state's deviation are negligible
constexpr double kMostLogsShare = 2.0 / 3.0;  // share of the logs that must improve
constexpr std::size_t kMostProducts = 3, kMostChannels = 16;

/// Normal equations of one log over all features: those of channels, then those of products.
struct LogSums {
  MatrixXd gram, cross;  // n x n, n x n_x
  VectorXd squares;      // n_x: sums of squares of the states
  double weight = 0.0;
};

class ProductSearch {
 public:
  explicit ProductSearch(const Dataset& data) : data_(data) {
    for (const Channel& output : data.outputs)
      if (output.expression.empty() && output.wrap == 0.0) names_.push_back(output.name);
    outputs_ = names_.size();
    if (data.reads_inputs)
      for (const Channel& input : data.inputs) names_.push_back(input.name);
    for (std::size_t i = 0; i < outputs_; ++i)
      for (std::size_t j = i; j < names_.size(); ++j) pairs_.emplace_back(i, j);
  }

  std::vector<FoundProduct> run() {
    if (outputs_ == 0 || names_.size() > kMostChannels) return {};
    normalise();
    for (const Trajectory& run : data_.trajectories) add(run);
    if (logs_.size() < kFewestProductLogs) return {};
    total_ = nothing();
    for (const auto& [name, log] : logs_) {
      total_.gram += log.gram;
      total_.cross += log.cross;
      total_.squares += log.squares;
      total_.weight += log.weight;
    }
    std::vector<FoundProduct> found;
    std::vector<std::size_t> taken;
    MatrixXd before = errors(taken);
    while (found.size() < kMostProducts) {
      std::size_t best = pairs_.size();
      double least = before.mean() + std::log(1.0 - kLeastGain);
      MatrixXd after;
      for (std::size_t p = 0; p < pairs_.size(); ++p) {
        if (std::find(taken.begin(), taken.end(), p) != taken.end()) continue;
        std::vector<std::size_t> with = taken;
        with.push_back(p);
        const MatrixXd log_errors = errors(with);
        const auto gains = static_cast<double>(((log_errors - before).colwise().mean().array() < 0.0).count());
        if (gains < kMostLogsShare * static_cast<double>(logs_.size()) || !(log_errors.mean() < least)) continue;
        least = log_errors.mean();
        best = p;
        after = log_errors;
      }
      if (best == pairs_.size()) break;
      const std::string &a = names_[pairs_[best].first], &b = names_[pairs_[best].second];
      found.push_back({a == b ? a + "_squared" : a + "_" + b, a == b ? a + "^2" : a + " * " + b,
                       1.0 - std::exp(after.mean() - before.mean())});
      taken.push_back(best);
      before = after;
    }
    return found;
  }

 private:
  Index nx() const { return states_; }
  LogSums nothing() const {
    return {MatrixXd::Zero(features(), features()), MatrixXd::Zero(features(), nx()), VectorXd::Zero(nx()), 0.0};
  }
  Index features() const { return 1 + kOf * static_cast<Index>(names_.size() + pairs_.size()); }

  MatrixXd channels_of(const Trajectory& run, Index first, Index count) const {
    MatrixXd channels(static_cast<Index>(names_.size()), count);
    Index row = 0;
    for (std::size_t j = 0; j < data_.outputs.size(); ++j)
      if (data_.outputs[j].expression.empty() && data_.outputs[j].wrap == 0.0)
        channels.row(row++) = run.outputs.row(static_cast<Index>(j)).segment(first, count);
    for (Index i = 0; row < channels.rows(); ++i) channels.row(row++) = run.inputs.row(i).segment(first, count);
    return channels;
  }

  /// Scales the features, so that products of large and small numbers are comparable in any unit.
  void normalise() {
    scale_ = VectorXd::Constant(static_cast<Index>(names_.size()), 1e-12);
    VectorXd sum;
    double weight = 0.0;
    for (const Trajectory& run : data_.trajectories) {
      scale_ = scale_.cwiseMax(channels_of(run, 0, run.samples()).cwiseAbs().rowwise().maxCoeff());
      const MatrixXd x = angles_encoded(run.states, data_.states);
      if (sum.size() == 0) sum = VectorXd::Zero(x.rows());
      for (Index k = 0; k < run.samples(); ++k)
        if (run.weight[k] > 0.0) sum += run.weight[k] * x.col(k), weight += run.weight[k];
    }
    mean_ = sum / std::max(weight, 1e-300);
    states_ = sum.size();
  }

  void add(const Trajectory& run) {
    LogSums& log = logs_[run.log.empty() ? run.source : run.log];
    if (log.gram.size() == 0) log = nothing();
    constexpr Index kBlock = 4096;  // all features of a long log would take many times the memory of its file
    VectorXd average[2];
    for (Index from = 0; from < run.samples(); from += kBlock)
      add(run, from, std::min(kBlock, run.samples() - from), average, log);
  }

  /// Adds `count` samples from `first` on. `average`: averages before these samples; updated.
  void add(const Trajectory& run, Index first, Index count, VectorXd (&average)[2], LogSums& log) const {
    const MatrixXd channels = scale_.cwiseInverse().asDiagonal() * channels_of(run, first, count);
    const auto now = channels.rows(), all = now + static_cast<Index>(pairs_.size());
    MatrixXd u(features(), count);
    VectorXd value(all);
    for (Index k = 0; k < count; ++k) {
      value.head(now) = channels.col(k);
      for (std::size_t p = 0; p < pairs_.size(); ++p)
        value[now + static_cast<Index>(p)] =
            channels(static_cast<Index>(pairs_[p].first), k) * channels(static_cast<Index>(pairs_[p].second), k);
      u(0, k) = 1.0;
      for (Index f = 0; f < kOf; ++f) {
        if (f > 0) {
          VectorXd& slow = average[f - 1];
          if (first + k == 0) slow = value;
          slow += (value - slow) / kAverages[f - 1];
        }
        const VectorXd& from = f == 0 ? value : average[f - 1];
        for (Index c = 0; c < all; ++c) u(1 + kOf * c + f, k) = from[c];
      }
    }
    MatrixXd x = angles_encoded(run.states.middleCols(first, count), data_.states).colwise() - mean_;
    const VectorXd weight = run.weight.segment(first, count).cwiseMax(0.0);
    for (Index k = 0; k < count; ++k)
      if (!(weight[k] > 0.0)) x.col(k).setZero(), u.col(k).setZero();
    const MatrixXd weighted = u * weight.asDiagonal();
    log.gram.noalias() += weighted * u.transpose();
    log.cross.noalias() += weighted * x.transpose();
    log.squares += x.cwiseAbs2() * weight;
    log.weight += weight.sum();
  }

  /// Returns the logarithms of the RMS error on each log, with these products and a fit on all other logs, n_x x logs.
  MatrixXd errors(const std::vector<std::size_t>& products) const {
    std::vector<Index> rows(1 + static_cast<std::size_t>(kOf) * names_.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Index>(i);
    for (const std::size_t p : products)
      for (Index f = 0; f < kOf; ++f) rows.push_back(1 + kOf * static_cast<Index>(names_.size() + p) + f);
    MatrixXd result(nx(), static_cast<Index>(logs_.size()));
    Index column = 0;
    for (const auto& [name, log] : logs_) {
      MatrixXd gram = (total_.gram - log.gram)(rows, rows);
      const MatrixXd own = log.gram(rows, rows), cross = log.cross(rows, Eigen::all);
      gram.diagonal().array() *= 1.0 + kRidge;
      gram.diagonal().array() += 1e-12 * gram.trace() + 1e-300;
      const MatrixXd w = codegen::solve_symmetric(gram, (total_.cross - log.cross)(rows, Eigen::all));
      for (Index i = 0; i < nx(); ++i) {
        const double square = log.squares[i] - 2.0 * w.col(i).dot(cross.col(i)) + w.col(i).dot(own * w.col(i));
        const double least = kNothing * kNothing * total_.squares[i] / std::max(total_.weight, 1e-300);
        result(i, column) = 0.5 * std::log(std::max(square / std::max(log.weight, 1e-300), least + 1e-300));
      }
      ++column;
    }
    return result;
  }

  const Dataset& data_;
  std::vector<std::string> names_;  // names of channels that may be a factor: outputs, then inputs
  std::size_t outputs_ = 0;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  VectorXd scale_, mean_;
  Index states_ = 0;
  std::map<std::string, LogSums> logs_;
  LogSums total_;
};

}  // namespace

std::vector<FoundProduct> find_products(const Dataset& training) {
  return ProductSearch(training).run();
}

}  // namespace nlo::trainer
