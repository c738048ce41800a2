// SPDX-License-Identifier: MIT
#include "trainer/data/run_loader.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/data/angle.h"
#include "trainer/data/empty_cells.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/zero_phase_filter.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

class RunLoader {
 public:
  RunLoader(const LogConfig& config, const LogSchema& schema, double sample_period_s, const LogFile& log,
            const LogRun& run)
      : config_(config),
        schema_(schema),
        sample_period_s_(sample_period_s),
        log_(log),
        run_(run),
        time_s_(time_of(run)),
        filtered_(std::any_of(schema.states.begin(), schema.states.end(), [](const auto& s) { return s.derivative; })) {
  }

  /// Loads the run. `steps`: adds the steps that were read.
  Trajectory load(std::vector<SuspiciousSteps>& steps) const {
    Trajectory result;
    result.source = run_.source;
    result.log = log_.path;
    result.time_s = time_s_;
    result.outputs = channels(schema_.outputs, schema_.output_channels.size(), steps);
    result.states = channels(schema_.states, schema_.state_channels.size(), steps);
    if (!schema_.inputs.empty()) result.inputs = channels(schema_.inputs, schema_.input_channels.size(), steps);
    result.weight = weights();
    apply_masks(result.weight);
    if (!log_.empty.empty()) {
      result.missing = missing_outputs();
      mask_empty_states(result.weight);
      if (result.weight.sum() == 0.0 && weights().sum() > 0.0)
        throw Error(
            "no row has a value of every state (rows near the ends do not count if a state is a velocity): use a log "
            "that contains the truth");
    }
    if (result.weight.sum() == 0.0)
      throw Error(
          fmt::format("{:.3g} s long, so every sample is within mask_edges_s = {} s of an end: use a longer log",
                      time_s_[run_.rows - 1], config_.velocity_filter.mask_edges_s));
    return result;
  }

 private:
  /// Returns the times of the run. Rounded stamps of a moving angle cause noise in its velocity (1 ms at 10 rad/s: 10
  /// mrad), so the even grid is the better clock. Stamps that jitter by more than their rounding are used unchanged.
  VectorXd time_of(const LogRun& run) const {
    if (!run.grid.rounded) return run.time_s;
    return run.grid.counts * (has_period(run.grid, sample_period_s_) ? sample_period_s_ : run.grid.period_s);
  }

  /// Reads a column. `truth`: empty cells are on straight lines, not held.
  VectorXd read(const LogColumn& column, bool truth, std::vector<SuspiciousSteps>& steps) const {
    VectorXd values = log_.values(column).segment(run_.first, run_.rows);
    if (column.wrap > 0.0) values = unwrap(values, column.wrap);
    if (truth) draw_lines(empty_rows(log_, run_, column.heading), time_s_, values);
    count_suspicious_steps(column, values, steps);
    return values;
  }

  Eigen::MatrixXd channels(const std::vector<LogColumn>& columns, std::size_t count,
                           std::vector<SuspiciousSteps>& steps) const {
    // Computed channels are filled later.
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Index>(count), run_.rows);
    Index channel = 0;
    for (const LogColumn& column : columns) {
      const VectorXd raw = read(column, &columns == &schema_.states, steps);
      if (column.delay_s > 0.0) {
        values.row(channel++) = delayed(time_s_, raw, column.delay_s).transpose();
      } else if (column.derivative) {
        const VectorXd velocity = zero_phase_velocity(config_.velocity_filter, time_s_, raw, sample_period_s_);
        values.row(channel++) = (column.rate == 1.0 ? velocity : column.rate * velocity).transpose();
      } else if (column.sincos) {
        values.row(channel++) = sine_of(raw, column.wrap).transpose();
        values.row(channel++) = cosine_of(raw, column.wrap).transpose();
      } else {
        values.row(channel++) = raw.transpose();
      }
    }
    return values;
  }

  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing_outputs() const {
    Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing(static_cast<Index>(schema_.output_channels.size()),
                                                               run_.rows);
    missing.setConstant(false);
    Index channel = 0;
    for (const LogColumn& output : schema_.outputs) {
      for (const Index row : empty_rows(log_, run_, output.heading))
        missing.block(channel, row, output.channels(), 1) = true;
      channel += output.channels();
    }
    if (!missing.any()) missing.resize(0, 0);
    return missing;
  }

  /// Masks states near long holes. A short hole of a position hardly shows in its velocity; a long one is like an end
  /// of the log.
  void mask_empty_states(VectorXd& weight) const {
    const double mask_s = config_.velocity_filter.mask_edges_s, long_s = 1.0 / config_.velocity_filter.cutoff_hz;
    for (const LogColumn& state : schema_.states)
      for_each_stretch(empty_rows(log_, run_, state.heading), [&](Index first, Index last) {
        const double from_s = time_s_[std::max<Index>(first - 1, 0)], to_s = time_s_[std::min(last + 1, run_.rows - 1)];
        const bool spreads = state.derivative && to_s - from_s > long_s;
        if (spreads)
          weight = (time_s_.array() > from_s - mask_s && time_s_.array() < to_s + mask_s).select(0.0, weight);
        weight.segment(first, last - first + 1).setZero();
      });
  }

  void apply_masks(VectorXd& weight) const {
    for (const LogColumn& mask : schema_.masks) {
      weight = (log_.values(mask).segment(run_.first, run_.rows).array() != 0.0).select(weight, 0.0);
      for (const Index row : empty_rows(log_, run_, mask.heading)) weight[row] = 0.0;
    }
    if (!schema_.masks.empty() && weight.sum() == 0.0)
      throw Error(
          "the columns with role \"mask\" exclude the truth of every row: use a log in which the truth of some rows "
          "counts");
  }

  VectorXd weights() const {
    const VectorXd weight = VectorXd::Ones(run_.rows);
    if (!filtered_) return weight;
    const double mask_s = config_.velocity_filter.mask_edges_s, end_s = time_s_[run_.rows - 1];
    return (time_s_.array() < mask_s || time_s_.array() > end_s - mask_s).select(0.0, weight);
  }

  const LogConfig& config_;
  const LogSchema& schema_;
  double sample_period_s_;
  const LogFile& log_;
  const LogRun& run_;
  VectorXd time_s_;
  bool filtered_;  ///< true if a state is a velocity
};

}  // namespace

Trajectory load_run(const LogConfig& config, const LogSchema& schema, double sample_period_s, const LogFile& log,
                    const LogRun& run, std::vector<SuspiciousSteps>& steps) {
  return RunLoader(config, schema, sample_period_s, log, run).load(steps);
}

}  // namespace nlo::trainer
