// SPDX-License-Identifier: MIT
#include "trainer/choose/readout_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/base/draws.h"
#include "trainer/choose/pilot.h"
#include "trainer/data/log_blocks.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostRuns = 128, kMostSamples = 16000, kMostFolds = 4;
constexpr int kPiece = 4096;                       // samples of a roll-out in memory; the row of a piece has 128 KiB
constexpr std::uint64_t kProbe = 0x70726f6265ULL;  // number of a step that no training has
constexpr double kLeast = 1e-16;                   // smaller squared errors are rounding
constexpr std::array kRidges = {1e-8, 1e-6, 1e-4, 1e-2, 1.0};

/// Scales each row to mean 0 and deviation 1, and a constant row to 0.
void standardise(MatrixXd& rows) {
  for (Index i = 0; i < rows.rows(); ++i) {
    const double mean = rows.row(i).mean();
    rows.row(i).array() -= mean;
    const double deviation = std::sqrt(rows.row(i).squaredNorm() / static_cast<double>(rows.cols()));
    if (deviation > 1e-9 * (std::abs(mean) + 1e-3))
      rows.row(i) /= deviation;
    else
      rows.row(i).setZero();
  }
}

/// Returns S^-1 u with S S' = cov(u). Directions in which features differ little, such as those of two fast modes, get
/// the same weight as the others.
MatrixXd whitened(const MatrixXd& u) {
  constexpr double kFloor = 1e-5;  // as a share of a unit variance; less is rounding or nearly nothing
  MatrixXd covariance = u * u.transpose() / static_cast<double>(u.cols());
  covariance.diagonal().array() += kFloor;
  return codegen::solve(codegen::square_root(covariance), u);
}

MatrixXd normal_matrix(Index rows, Index cols, std::uint64_t stream) {
  RandomLanes random(stream_seed(stream, Purpose::kWeights, kProbe, 0));
  MatrixXd result(rows, cols);
  float draw[2 * RandomLanes::kLanes];
  for (Index i = 0; i < result.size(); ++i) {
    const auto at = static_cast<std::size_t>(i % (2 * RandomLanes::kLanes));
    if (at == 0) random.normal_pair(draw, draw + RandomLanes::kLanes);
    result.data()[i] = static_cast<double>(draw[at]);
  }
  return result;
}

/// Returns [1; u; tanh(R u + r)], where half of R is for whitened features.
MatrixXd with_random_features(const MatrixXd& u, int count) {
  const Index half = count / 2, nf = u.rows();
  MatrixXd phi(1 + nf + 2 * half, u.cols());
  phi.row(0).setOnes();
  phi.middleRows(1, nf) = u;
  if (half == 0) return phi;
  const double scale = 1.0 / std::sqrt(static_cast<double>(nf));
  const auto units = [&](const MatrixXd& v, std::uint64_t stream) {
    MatrixXd a = normal_matrix(half, nf, stream) * scale * v;
    a.colwise() += VectorXd(normal_matrix(half, 1, stream + 1));
    return MatrixXd(a.array().tanh());
  };
  phi.middleRows(1 + nf, half) = units(u, 1);
  phi.bottomRows(half) = units(whitened(u), 3);
  return phi;
}

/// Sums over the samples of a fold.
struct Sums {
  MatrixXd gram, cross;
  VectorXd power;  ///< mean squares of the states
};

}  // namespace

double ReadoutError::mean_log() const {
  constexpr double kFloor = 1e-3;
  double sum = 0.0;
  for (std::size_t i = 0; i < linear.size(); ++i) sum += std::log(std::min(linear[i], curved[i]) + kFloor);
  return linear.empty() ? 0.0 : sum / static_cast<double>(linear.size());
}

ReadoutProbe::ReadoutProbe(const Experiment& base, const Dataset& training)
    : dataset_(training),
      failures_(structure_of(base.observer).failures(base, training)),
      data_(training, failures_),
      pool_(base.threads),
      rollout_(data_) {
  draw_segments(base, training);
  draw_samples(base);
}

/// Draws whole runs, or pieces of the runs of logs, because an observer of logs may be started anywhere.
void ReadoutProbe::draw_segments(const Experiment& base, const Dataset& training) {
  std::map<std::string, int> sources;
  for (const Trajectory& run : training.trajectories) {
    const int source = base.log ? sources.emplace(run.log, static_cast<int>(sources.size())).first->second
                                : static_cast<int>(fold_of_run_.size());
    fold_of_run_.push_back(source);
  }
  const int count = base.log ? static_cast<int>(sources.size()) : static_cast<int>(fold_of_run_.size());
  by_block_ = base.log && count == 1;
  folds_ = by_block_ ? kMostFolds : std::clamp(count, 1, kMostFolds);
  for (int& fold : fold_of_run_) fold %= folds_;
  const std::size_t runs = data_.runs.size(), taken = std::min<std::size_t>(runs, kMostRuns);
  Draws draws(base.seed + kProbe);
  for (std::size_t i = 0; i < taken; ++i) {
    const auto run = static_cast<int>(i * runs / taken);
    const int samples = data_.runs[static_cast<std::size_t>(run)].samples;
    std::vector<Segment> pieces = {{.run = run, .start = 0, .length = samples}};
    for (int piece = 0; base.log && piece < 3; ++piece) {
      const int length = std::max(2, std::min(samples, samples / 3));
      pieces.push_back({.run = run,
                        .start = static_cast<int>(draws.below(static_cast<std::size_t>(samples - length + 1))),
                        .length = length});
    }
    for (Segment& piece : pieces) {
      piece.mirrored = !data_.mirror.none() && segments_.size() % 2 == 1;
      if (base.training.noise_level_max > 0.0)
        piece.noise_level =
            static_cast<float>(base.training.noise_level_max * static_cast<double>(draws.below(1000)) / 999.0);
      segments_.push_back(piece);
    }
  }
}

void ReadoutProbe::draw_samples(const Experiment& base) {
  std::vector<Sample> all;
  Draws draws(base.seed + kProbe + 1);
  const std::size_t each = std::max<std::size_t>(8, kMostSamples / segments_.size());
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const Segment& segment = segments_[s];
    const TrainingData::Run& run = data_.runs[static_cast<std::size_t>(segment.run)];
    const int first = std::max(0, run.first_estimate - segment.start);
    if (first >= segment.length) continue;
    const auto length = static_cast<std::size_t>(segment.length - first);
    for (std::size_t i = 0; i < each; ++i) {  // one from each part of the segment
      const std::size_t from = i * length / each, to = std::max(from + 1, (i + 1) * length / each);
      const int time = first + static_cast<int>(std::min(from + draws.below(to - from), length - 1));
      if (run.weight[static_cast<std::size_t>(segment.start + time)] <= 0.0F) continue;
      const int fold = by_block_ ? block_of(segment.start + time, run.samples, folds_)
                                 : fold_of_run_[static_cast<std::size_t>(segment.run)];
      all.push_back({static_cast<int>(s) / kGroup, static_cast<int>(s) % kGroup, time, fold});
    }
  }
  if (all.empty()) throw codegen::Error("the recipe finds no sample to measure on: all truth is masked");
  for (std::size_t i = all.size() - 1; i > 0; --i) std::swap(all[i], all[draws.below(i + 1)]);
  if (all.size() > kMostSamples) all.resize(kMostSamples);
  samples_ = std::move(all);
  states_.resize(data_.nx, static_cast<Index>(samples_.size()));
  rollout_ = Rollout(data_);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const Segment& segment = segments_[static_cast<std::size_t>(samples_[k].group * kGroup + samples_[k].lane)];
    for (int i = 0; i < data_.nx; ++i)
      states_(i, static_cast<Index>(k)) =
          static_cast<double>(rollout_.state(segment, static_cast<std::size_t>(i), samples_[k].time));
  }
  standardise(states_);
}

/// Returns the features of the first `count` samples.
MatrixXd ReadoutProbe::features(const Experiment& experiment, int count) {
  const ObserverStructure structure = [&] {
    ObserverStructure made = make_structure(experiment, false, dataset_.outputs, dataset_.states,
                                            dataset_.inputs_read(), static_cast<int>(failures_.outputs.size()));
    normalise_dynamics(made, data_, pool_);
    return made;
  }();
  const auto dynamics = structure.module->latent_dynamics(experiment, structure, data_.steps_s, pool_.threads());
  dynamics->prepare(initial_dynamics(structure, experiment).data());
  // Columns of u that each group fills, in the order of time.
  std::vector<std::vector<Index>> columns((segments_.size() + kGroup - 1) / kGroup);
  for (Index k = 0; k < count; ++k)
    columns[static_cast<std::size_t>(samples_[static_cast<std::size_t>(k)].group)].push_back(k);
  const auto time = [&](Index k) { return samples_[static_cast<std::size_t>(k)].time; };
  for (std::vector<Index>& of_group : columns) std::ranges::stable_sort(of_group, {}, time);
  MatrixXd u(static_cast<Index>(structure.features.size()), count);
  const auto keep = [&](int index, int first, const SegmentGroup& piece) {
    const std::vector<Index>& all = columns[static_cast<std::size_t>(index)];
    for (auto k = std::ranges::lower_bound(all, first, {}, time); k != all.end() && time(*k) < first + piece.length;
         ++k)
      for (Index f = 0; f < u.rows(); ++f)
        u(f, *k) =
            static_cast<double>(normalised_feature(structure.features[static_cast<std::size_t>(f)], piece,
                                                   samples_[static_cast<std::size_t>(*k)].lane, time(*k) - first));
  };
  rollout_.run_in_pieces(segments_, *dynamics, experiment.training.all_noise(), experiment.seed, Purpose::kNoise,
                         kProbe, pool_, experiment.training.input_noise, kPiece, keep);
  return u;
}

ReadoutError ReadoutProbe::error(const Experiment& experiment, int random_features, int samples) {
  const int count = std::min(samples, static_cast<int>(samples_.size()));
  MatrixXd u = features(experiment, count);
  ReadoutError result;
  result.rows = static_cast<int>(u.rows());
  const auto nx = static_cast<std::size_t>(data_.nx);
  if (!u.allFinite()) {  // an unstable step: not a candidate
    result.linear = result.curved = std::vector<double>(nx, 1e3);
    return result;
  }
  standardise(u);
  const Index linear = 1 + u.rows();
  const MatrixXd phi = with_random_features(u, random_features);

  const auto folds = static_cast<std::size_t>(folds_);
  std::vector<Sums> sums(folds);
  pool_.run(folds_, [&](int fold, int) {
    std::vector<Index> own;
    for (int k = 0; k < count; ++k)
      if (samples_[static_cast<std::size_t>(k)].fold == fold) own.push_back(k);
    const MatrixXd part = phi(Eigen::all, own), x = states_(Eigen::all, own);
    Sums& sum = sums[static_cast<std::size_t>(fold)];
    sum.gram = MatrixXd::Zero(phi.rows(), phi.rows());
    sum.gram.selfadjointView<Eigen::Lower>().rankUpdate(part);
    sum.gram.triangularView<Eigen::StrictlyUpper>() = sum.gram.transpose();
    sum.cross = part * x.transpose();
    sum.power = x.rowwise().squaredNorm();
  });
  MatrixXd gram = MatrixXd::Zero(phi.rows(), phi.rows()), cross = MatrixXd::Zero(phi.rows(), data_.nx);
  for (const Sums& sum : sums) {
    gram += sum.gram;
    cross += sum.cross;
  }

  // Squared errors (ridge x state) of the first rows of phi.
  const auto errors = [&](Index rows) {
    std::vector<MatrixXd> of_fold(folds, MatrixXd::Zero(static_cast<Index>(kRidges.size()), data_.nx));
    pool_.run(folds_, [&](int f, int) {
      const Sums& out = sums[static_cast<std::size_t>(f)];
      const bool alone = folds_ == 1;
      MatrixXd normal = alone ? gram : MatrixXd(gram - out.gram);
      const MatrixXd right = alone ? cross : MatrixXd(cross - out.cross);
      normal = normal.topLeftCorner(rows, rows).eval();
      const double total = std::max(normal(0, 0), 1.0);
      for (std::size_t r = 0; r < kRidges.size(); ++r) {
        MatrixXd damped = normal;
        damped.diagonal().tail(rows - 1).array() += kRidges[r] * total;
        const MatrixXd w = codegen::solve_symmetric(damped, right.topRows(rows));
        const MatrixXd gw = out.gram.topLeftCorner(rows, rows) * w;
        for (Index i = 0; i < w.cols(); ++i)
          of_fold[static_cast<std::size_t>(f)](static_cast<Index>(r), i) =
              out.power(i) - 2.0 * w.col(i).dot(out.cross.col(i).head(rows)) + w.col(i).dot(gw.col(i));
      }
    });
    // The geometric mean over folds, so that a log which differs from all others does not decide alone.
    MatrixXd logs = MatrixXd::Zero(static_cast<Index>(kRidges.size()), data_.nx);
    double counted = 0.0;
    for (std::size_t f = 0; f < folds; ++f) {
      const double own = sums[f].gram(0, 0);  // the number of samples, because feature 0 is 1
      if (own == 0.0) continue;
      logs.array() += own * (of_fold[f].array() / own).cwiseMax(kLeast).log() / 2.0;
      counted += own;
    }
    return MatrixXd((logs / counted).array().exp());
  };
  const MatrixXd by_line = errors(linear), by_curve = errors(phi.rows());
  Index best = 0;
  by_line.rowwise().sum().minCoeff(&best);
  result.ridge = kRidges[static_cast<std::size_t>(best)];
  for (Index i = 0; i < data_.nx; ++i) {
    result.linear.push_back(by_line.col(i).minCoeff());
    result.curved.push_back(by_curve.col(i).minCoeff());
  }
  return result;
}

}  // namespace nlo::trainer
