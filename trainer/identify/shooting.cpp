// SPDX-License-Identifier: MIT
#include "trainer/identify/shooting.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/identify/segment_simulation.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kStep = 1e-7;    // relative step of forward differences, a compromise between rounding and curvature
constexpr double kFarAway = 1e6;  // replaces a residual that is NaN [deviations]
constexpr int kMostIterations = 20, kMostHalvings = 8;

Index row_of(const std::vector<Channel>& channels, const std::string& name) {
  const auto found =
      std::find_if(channels.begin(), channels.end(), [&](const Channel& channel) { return channel.name == name; });
  return found == channels.end() ? -1 : found - channels.begin();
}

Index place_of_name(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) - names.begin();
}

}  // namespace

std::vector<FittedChannel> fitted_channels(const Identification& identification, const Dataset& logs) {
  std::vector<FittedChannel> channels;
  for (const auto& [name, deviation] : identification.identify.noise) {
    FittedChannel channel{name, "", false, row_of(logs.outputs, name), 0, deviation, 0.0};
    const auto& outputs = identification.plant.output_names;
    channel.state = std::find(outputs.begin(), outputs.end(), name) == outputs.end();
    if (channel.state) channel.log_row = row_of(logs.states, name);
    const Channel& logged = (channel.state ? logs.states : logs.outputs)[static_cast<std::size_t>(channel.log_row)];
    channel.plant_row = place_of_name(channel.state ? identification.plant.states : outputs, name);
    channel.unit = logged.unit;
    channel.wrap = logged.wrap;
    channels.push_back(channel);
  }
  return channels;
}

/// The plant of one thread.
class ShootingProblem::Worker {
 public:
  explicit Worker(const ShootingProblem& problem)
      : problem_(problem), simulation_(problem.identification_, problem.channels_, problem.input_rows_) {}

  /// Returns the rows of one segment from x0 with p.
  VectorXd residuals(const Segment& s, const VectorXd& p, const VectorXd& x0) {
    VectorXd r = simulation_.residuals(*s.run, s.first, s.samples, p, x0);
    const VectorXd& deviation = deviations();
    const Index fitted = r.size();
    r.conservativeResize(problem_.rows_of(s));
    for (Index i = 0, row = fitted; i < x0.size(); ++i)
      if (deviation[i] > 0.0) r[row++] = (x0[i] - s.guess[i]) / deviation[i];
    for (double& value : r)
      if (!(std::abs(value) < kFarAway)) value = kFarAway;
    return r;
  }

  /// Returns dr/dx0 of the free states.
  MatrixXd slope(const Segment& s, const VectorXd& p, const VectorXd& x0, const VectorXd& r) {
    MatrixXd j(r.size(), problem_.free_);
    for (Index i = 0, column = 0; i < x0.size(); ++i) {
      if (!(deviations()[i] > 0.0)) continue;
      const double step = kStep * std::max(std::abs(x0[i]), deviations()[i]);
      VectorXd moved = x0;
      moved[i] += step;
      j.col(column++) = (residuals(s, p, moved) - r) / step;
    }
    return j;
  }

  struct Fitted {
    VectorXd x0, r;
  };

  /// Fits the initial state by the method of Gauss and Newton with step halving, starting at s.start.
  Fitted fit(const Segment& s, const VectorXd& p) {
    Fitted best{s.start, residuals(s, p, s.start)};
    for (int i = 0; i < kMostIterations; ++i) {
      if (problem_.free_ == 0) break;
      const VectorXd step = slope(s, p, best.x0, best.r).colPivHouseholderQr().solve(-best.r);
      const double before = best.r.squaredNorm();
      bool better = false;
      double share = 1.0;
      for (int halving = 0; halving < kMostHalvings && !better; ++halving, share *= 0.5) {
        VectorXd x0 = best.x0;
        for (Index k = 0, column = 0; k < x0.size(); ++k)
          if (deviations()[k] > 0.0) x0[k] += share * step[column++];
        VectorXd r = residuals(s, p, x0);
        better = r.squaredNorm() < before;
        if (!better) continue;
        best.x0 = std::move(x0);
        best.r = std::move(r);
      }
      constexpr double kConverged = 1e-9;  // relative decrease of the sum of squares
      if (!better || before - best.r.squaredNorm() < kConverged * before) break;
    }
    return best;
  }

 private:
  const VectorXd& deviations() {
    if (deviations_.size() == 0) {
      const auto& given = problem_.identification_.identify.initial_deviation;
      deviations_ = VectorXd::Map(given.data(), static_cast<Index>(given.size()));
    }
    return deviations_;
  }

  const ShootingProblem& problem_;
  SegmentSimulation simulation_;
  VectorXd deviations_;
};

ShootingProblem::ShootingProblem(const Identification& identification, const Dataset& logs, ThreadPool& pool)
    : identification_(identification),
      pool_(pool),
      space_(identification.plant, identification.identify),
      channels_(fitted_channels(identification, logs)) {
  for (const std::string& input : identification.plant.inputs) input_rows_.push_back(row_of(logs.inputs, input));
  for (const std::string& state : identification.plant.states) {
    const Index logged = row_of(logs.states, state), output = row_of(logs.outputs, state);
    guesses_.emplace_back(logged >= 0, logged >= 0 ? logged : output);
  }
  for (const double deviation : identification.identify.initial_deviation) free_ += deviation > 0.0 ? 1 : 0;

  std::vector<Segment> all;
  Index total = 0;
  const double length_s = identification.identify.segment_s;
  for (const Trajectory& run : logs.trajectories)
    for (Index first = 0; first < run.samples();) {
      const double* end = run.time_s.data() + run.samples();
      const double until = run.time_s[first] + length_s - 1e-6 * logs.sample_period_s;
      const Index past = std::lower_bound(run.time_s.data() + first, end, until) - run.time_s.data();
      if (past >= run.samples()) break;  // the remainder is shorter than a segment
      all.push_back({&run, first, past - first, 0, guess_of(run, first), {}});
      total += past - first;
      first = past;
    }
  if (all.empty())
    throw codegen::Error(
        fmt::format("[identify] segment_s = {} s is longer than every log; choose a shorter one", length_s));
  const auto stride = static_cast<std::size_t>(
      std::max<Index>(1, (total + identification.identify.most_samples - 1) / identification.identify.most_samples));
  for (std::size_t i = 0; i < all.size(); i += stride) {
    Segment& segment = segments_.emplace_back(std::move(all[i]));
    segment.start = segment.guess;
    segment.row = rows_;
    rows_ += rows_of(segment);
    samples_ += segment.samples;
    for (const FittedChannel& channel : channels_)
      counted_ += channel.state ? (segment.run->weight.segment(segment.first, segment.samples).array() > 0.0).count()
                                : segment.samples;
  }
  for (int i = 0; i < pool.threads(); ++i) workers_.push_back(std::make_unique<Worker>(*this));
}

ShootingProblem::~ShootingProblem() = default;

VectorXd ShootingProblem::guess_of(const Trajectory& run, Index sample) const {
  const auto& given = identification_.identify.initial_state;
  VectorXd guess = VectorXd::Map(given.data(), static_cast<Index>(given.size()));
  for (std::size_t i = 0; i < guesses_.size(); ++i) {
    const auto& [logged, row] = guesses_[i];
    if (row < 0) continue;
    // Masked truth is accurate enough for a start value.
    const double value = (logged ? run.states : run.outputs)(row, sample);
    if (std::isfinite(value)) guess[static_cast<Index>(i)] = value;
  }
  return guess;
}

Index ShootingProblem::rows_of(const Segment& segment) const {
  return segment.samples * static_cast<Index>(channels_.size()) + free_;
}

VectorXd ShootingProblem::residuals(const VectorXd& theta) {
  const VectorXd p = space_.parameters(theta);
  VectorXd r(rows_);
  pool_.run(static_cast<int>(segments_.size()), [&](int index, int thread) {
    const Segment& s = segments_[static_cast<std::size_t>(index)];
    r.segment(s.row, rows_of(s)) = workers_[static_cast<std::size_t>(thread)]->fit(s, p).r;
  });
  return r;
}

MatrixXd ShootingProblem::jacobian(const VectorXd& theta) {
  const VectorXd p = space_.parameters(theta);
  MatrixXd jacobian(rows_, space_.size());
  pool_.run(static_cast<int>(segments_.size()), [&](int index, int thread) {
    Segment& s = segments_[static_cast<std::size_t>(index)];
    Worker& worker = *workers_[static_cast<std::size_t>(thread)];
    const Worker::Fitted fitted = worker.fit(s, p);
    s.start = fitted.x0;
    MatrixXd j(fitted.r.size(), space_.size());
    for (Index i = 0; i < space_.size(); ++i) {
      VectorXd moved = theta;
      moved[i] += kStep;
      j.col(i) = (worker.residuals(s, space_.parameters(moved), fitted.x0) - fitted.r) / kStep;
    }
    if (free_ > 0) {
      const MatrixXd slope = worker.slope(s, p, fitted.x0, fitted.r);
      const MatrixXd q = slope.householderQr().householderQ() * MatrixXd::Identity(slope.rows(), slope.cols());
      s.told = q.topRows(q.rows() - free_).squaredNorm();
      j -= q * (q.transpose() * j);
    }
    jacobian.middleRows(s.row, j.rows()) = j;
  });
  return jacobian;
}

double ShootingProblem::told_states() const {
  double told = 0.0;
  for (const Segment& s : segments_) told += s.told;
  return told;
}

double ShootingProblem::squares(const VectorXd& residuals) const {
  double squares = 0.0;
  for (const Segment& s : segments_) squares += residuals.segment(s.row, rows_of(s) - free_).squaredNorm();
  return squares;
}

MatrixXd ShootingProblem::scatter(const MatrixXd& jacobian, const VectorXd& residuals) const {
  MatrixXd sum = MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  for (const Segment& s : segments_) {
    const VectorXd gradient = jacobian.middleRows(s.row, rows_of(s)).transpose() * residuals.segment(s.row, rows_of(s));
    sum += gradient * gradient.transpose();
  }
  return sum;
}

std::vector<ShootingProblem::ChannelError> ShootingProblem::errors(const VectorXd& residuals) const {
  std::vector<ChannelError> errors;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    double squares = 0.0, neighbours = 0.0, pairs = 0.0, count = 0.0;
    for (const Segment& s : segments_) {
      double before = 0.0;
      for (Index k = 0; k < s.samples; ++k) {
        const double r = residuals[s.row + k * static_cast<Index>(channels_.size()) + static_cast<Index>(c)];
        if (channels_[c].state && s.run->weight[s.first + k] <= 0.0) continue;
        squares += r * r;
        count += 1.0;
        if (k > 0) neighbours += r * before;
        if (k > 0) pairs += 1.0;
        before = r;
      }
    }
    const double mean = count > 0.0 ? squares / count : std::nan("");
    errors.push_back({channels_[c].deviation * std::sqrt(mean), pairs > 0.0 ? neighbours / pairs / mean : 0.0});
  }
  return errors;
}

}  // namespace nlo::trainer
