// SPDX-License-Identifier: MIT
#include "trainer/structures/flight_record.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "codegen/structures/structure_module.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXi;
using Eigen::VectorXd;

constexpr Index kSamples = 12000;  // an export measures its error over 10,000 samples in the domain

/// A segment of the rollout, the place of its samples in the rollout, and the range of samples to record.
struct Piece {
  int group, lane;
  Segment segment;
  int first, length;  ///< samples of the segment
};

struct Place {
  int group, lane;
};

/// Returns eight time constants of the slowest mode, so that the transient is over for most of a piece.
int piece_length(const codegen::Model& model) {
  constexpr double kShortest = 500.0, kLongest = 3000.0, kTimeConstants = 8.0;
  const std::optional<double> rate = codegen::module_of(model).slowest_mode(model);
  const double slowest = rate ? 1.0 / (*rate * model.sample_period_s) : 0.0;  // time constant in sample periods
  return static_cast<int>(std::clamp(kTimeConstants * slowest, kShortest, kLongest));
}

std::vector<Piece> pieces_of(const Rollout& rollout, int longest) {
  std::vector<Place> places;
  Index possible = 0, total = 0;  // samples: with one piece for each segment; with whole segments
  const auto runs = static_cast<int>(whole_runs(rollout.data()).size());  // the whole runs are the first segments
  for (std::size_t g = 0; g < rollout.groups().size(); ++g)
    for (int l = 0; l < rollout.groups()[g].lanes && static_cast<int>(g) * kGroup + l < runs; ++l) {
      places.push_back({static_cast<int>(g), l});
      total += rollout.segment(static_cast<int>(g), l).length;
      possible += std::min(rollout.segment(static_cast<int>(g), l).length, longest);
    }
  if (possible == 0) return {};
  std::vector<Piece> pieces;
  if (total <= kSamples) {
    for (const Place& place : places) {
      const Segment& segment = rollout.segment(place.group, place.lane);
      pieces.push_back({place.group, place.lane, segment, 0, segment.length});
    }
    return pieces;
  }
  const auto all = static_cast<Index>(places.size());
  const Index visited = std::clamp<Index>((kSamples * all + possible - 1) / possible, 1, all);
  // Pieces of each segment, if one is not enough.
  const int each = static_cast<int>((kSamples + possible - 1) / possible);
  for (Index i = 0; i < visited; ++i) {
    const Place& place = places[static_cast<std::size_t>(i * all / visited)];
    const Segment& segment = rollout.segment(place.group, place.lane);
    const int length = std::min(segment.length, longest);
    const int count = visited < all ? 1 : std::clamp(segment.length / std::max(length, 1), 1, each);
    for (int k = 0; k < count; ++k) {
      // If a run has several pieces, they are spread from its start to its end. If each run has one piece, every second
      // piece begins at the start of its run.
      constexpr double kGolden = 0.618033988749895;
      const double at = count > 1    ? static_cast<double>(k) / (count - 1)
                        : i % 2 == 0 ? 0.0
                                     : std::fmod(kGolden * static_cast<double>(i), 1.0);
      const int first = static_cast<int>(at * (segment.length - length));
      pieces.push_back({place.group, place.lane, segment, first, length});
    }
  }
  return pieces;
}

/// Returns n_r x N readings with noise; whole turns of angles are removed.
MatrixXd readings_of(const Piece& piece, const Rollout& rollout, const std::vector<codegen::Channel>& channels) {
  const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(piece.group)];
  MatrixXd readings(static_cast<Index>(channels.size()), piece.length);
  for (Index j = 0; j < readings.rows(); ++j) {
    const double wrap = channels[static_cast<std::size_t>(j)].wrap;
    for (int k = 0; k < piece.length; ++k) {
      const double y = static_cast<double>(
          group.readings[group.at(static_cast<int>(j), piece.first + k) + static_cast<std::size_t>(piece.lane)]);
      readings(j, k) = wrap > 0.0 ? y - wrap * std::round(y / wrap) : y;
    }
  }
  return readings;
}

/// Returns n_u x N inputs that the observer does not read. They are zero for a driven plant that is trained on runs
/// without inputs.
MatrixXd inputs_of(const Piece& piece, const Dataset& dataset, Index channels) {
  const Trajectory& run = dataset.trajectories[static_cast<std::size_t>(piece.segment.run)];
  if (run.inputs.rows() != channels) return MatrixXd::Zero(channels, piece.length);
  return run.inputs.middleCols(piece.segment.start + piece.first, piece.length);
}

/// Returns the smallest and the largest value of each channel over all pieces, n x 2.
MatrixXd range_of(const std::vector<MatrixXd>& signals) {
  MatrixXd range(signals.front().rows(), 2);
  range << signals.front().rowwise().minCoeff(), signals.front().rowwise().maxCoeff();
  for (const MatrixXd& signal : signals) {
    range.col(0) = range.col(0).cwiseMin(signal.rowwise().minCoeff());
    range.col(1) = range.col(1).cwiseMax(signal.rowwise().maxCoeff());
  }
  return range;
}

VectorXd steps_for(const std::vector<MatrixXd>& signals) {
  const MatrixXd range = range_of(signals);
  VectorXd steps(range.rows());
  for (Index j = 0; j < steps.size(); ++j)
    steps(j) = codegen::flight_step(range(j, 1) - range(j, 0), range.row(j).cwiseAbs().maxCoeff());
  return steps;
}

MatrixXi counts(const MatrixXd& signal, const VectorXd& steps) {
  return (steps.cwiseInverse().asDiagonal() * signal).array().round().matrix().cast<int>();
}

}  // namespace

void record_flight(codegen::Model& model, const Dataset& dataset, const Rollout& rollout) {
  const std::vector<Piece> pieces = pieces_of(rollout, piece_length(model));
  std::vector<MatrixXd> outputs, inputs;
  double longest_s = dataset.sample_period_s;
  for (const Piece& piece : pieces) {
    const MatrixXd readings = readings_of(piece, rollout, codegen::readings(model));
    outputs.push_back(readings.topRows(model.ny()));
    if (model.nu() > 0)
      inputs.push_back(!model.inputs.empty() ? MatrixXd(readings.middleRows(model.ny(), model.nu()))
                                             : inputs_of(piece, dataset, model.nu()));
    const VectorXd& time_s = dataset.trajectories[static_cast<std::size_t>(piece.segment.run)].time_s;
    const int start = piece.segment.start + piece.first;
    for (int k = 1; k < piece.length; ++k) longest_s = std::max(longest_s, time_s(start + k) - time_s(start + k - 1));
  }
  codegen::Flight& flight = model.flight;
  flight = {};
  if (pieces.empty()) return;
  flight.output_step = steps_for(outputs);
  if (model.nu() > 0) flight.input_step = steps_for(inputs);
  flight.dt_step_s = codegen::flight_step(16.0 * dataset.sample_period_s, longest_s);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    codegen::FlightRun run;
    run.outputs = counts(outputs[i], flight.output_step);
    if (model.nu() > 0) run.inputs = counts(inputs[i], flight.input_step);
    if (!dataset.uniform) {
      const VectorXd& time_s = dataset.trajectories[static_cast<std::size_t>(piece.segment.run)].time_s;
      const int start = piece.segment.start + piece.first;
      run.dt.resize(piece.length);
      for (int k = 0; k < piece.length; ++k) {
        const double dt_s = k == 0 ? dataset.sample_period_s : time_s(start + k) - time_s(start + k - 1);
        run.dt(k) = std::max(1, static_cast<int>(std::lround(dt_s / flight.dt_step_s)));
      }
    }
    flight.runs.push_back(std::move(run));
  }
}

}  // namespace nlo::trainer
