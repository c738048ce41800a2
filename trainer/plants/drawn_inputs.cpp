// SPDX-License-Identifier: MIT
// Compiled with -ffp-contract=off, for the reason in run_random.cpp.
#include "trainer/plants/drawn_inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/plants/run_random.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

constexpr int kTones = 5;  ///< tones of a multisine

/// The parameters of one drawn signal, and its stream.
class SignalSource {
 public:
  SignalSource(const ExcitationConfig& excitation, const SimulationConfig& simulation, std::size_t input,
               RunRandom& random)
      : low_(excitation.low[input]),
        high_(excitation.high[input]),
        least_(excitation.amplitude.empty() ? 0.0 : excitation.amplitude[0]),
        most_(excitation.amplitude.empty() ? half_range() : excitation.amplitude[1]),
        times_(hold_times(excitation, simulation)),
        period_(simulation.sample_period_s),
        values_(Eigen::RowVectorXd::Zero(sample_count(simulation))),
        random_(random) {}

  Eigen::RowVectorXd draw(InputSignal kind);

 private:
  double middle() const { return 0.5 * low_ + 0.5 * high_; }
  double half_range() const { return 0.5 * high_ - 0.5 * low_; }
  double level() { return random_.between(low_, high_); }
  double amplitude() { return random_.between(least_, most_); }
  double time() { return random_.log_between(times_.shortest_s, times_.longest_s); }
  double time_of(Eigen::Index k) const { return static_cast<double>(k) * period_; }

  void draw_zero() {}

  void draw_constant() { values_.setConstant(level()); }

  void draw_steps() {
    double value = 0.0, next = 0.0;
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      while (time_of(k) >= next) {
        value = level();
        next += time();
      }
      values_(k) = value;
    }
  }

  void draw_prbs() {
    const double first = level(), second = level(), clock = time();
    double value = first, next = 0.0;
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      while (time_of(k) >= next) {
        value = random_.uniform() < 0.5 ? first : second;
        next += clock;
      }
      values_(k) = value;
    }
  }

  void draw_sine() { draw_sines(1); }

  void draw_multisine() { draw_sines(kTones); }

  void draw_sines(int tones) {
    const double size = amplitude() / static_cast<double>(tones);
    values_.setConstant(middle());
    for (int tone = 0; tone < tones; ++tone) {
      const double cycle = time(), phase = random_.uniform();
      for (Eigen::Index k = 0; k < values_.size(); ++k) values_(k) += size * sine_of_turns(time_of(k) / cycle + phase);
    }
  }

  void draw_square() {
    const double size = amplitude(), cycle = time(), phase = random_.uniform();
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      const double turns = time_of(k) / cycle + phase;
      values_(k) = middle() + (turns - std::floor(turns) < 0.5 ? size : -size);
    }
  }

  void draw_chirp() {
    const double size = amplitude(), first = time(), last = time();
    const auto steps = static_cast<double>(std::max<Eigen::Index>(values_.size() - 1, 1));
    const double ratio = portable_exp(portable_log(first / last) / steps);
    double turns = random_.uniform(), per_sample = period_ / first;
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      values_(k) = middle() + size * sine_of_turns(turns);
      turns += per_sample;
      per_sample *= ratio;
    }
  }

  void draw_noise() {
    constexpr double kTwoPi = 6.283185307179586;
    const double kept = portable_exp(-std::min(kTwoPi * period_ / time(), 500.0));
    const double fresh = std::sqrt(1.0 - kept * kept);
    double state = random_.normal();  // stationary from the first sample on
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      double share = 0.5 * state;                      // fraction of half the range; reflected at the ends of the range
      share -= 4.0 * std::floor((share + 1.0) / 4.0);  // -1 .. 3
      values_(k) = middle() + half_range() * (share <= 1.0 ? share : 2.0 - share);
      state = kept * state + fresh * random_.normal();
    }
  }

  /// A row for each kind of signal, in the order of InputSignal.
  struct Row {
    InputSignal kind;
    void (SignalSource::*draw)();  ///< fills values_; null: draw_inputs() reads the signal from a log
    bool in_range = true;          ///< clips to the range, because c + A may exceed it by rounding
  };
  static constexpr std::size_t kRows = kNames<InputSignal>.size();
  static std::array<Row, kRows> rows();

  double low_, high_, least_, most_;
  HoldTimes times_;
  double period_;
  Eigen::RowVectorXd values_;
  RunRandom& random_;
};

std::array<SignalSource::Row, SignalSource::kRows> SignalSource::rows() {
  using enum InputSignal;
  using S = SignalSource;
  return {{{kZero, &S::draw_zero, false},
           {kConstant, &S::draw_constant},
           {kSteps, &S::draw_steps},
           {kPrbs, &S::draw_prbs},
           {kSine, &S::draw_sine},
           {kSquare, &S::draw_square},
           {kMultisine, &S::draw_multisine},
           {kChirp, &S::draw_chirp},
           {kNoise, &S::draw_noise},
           {kLog, nullptr}}};
}

Eigen::RowVectorXd SignalSource::draw(InputSignal kind) {
  for (const Row& row : rows()) {
    if (row.kind != kind || row.draw == nullptr) continue;
    (this->*row.draw)();
    return row.in_range ? Eigen::RowVectorXd(values_.cwiseMax(low_).cwiseMin(high_)) : values_;
  }
  throw std::logic_error("a kind of input without a row");
}

}  // namespace

HoldTimes hold_times(const ExcitationConfig& excitation, const SimulationConfig& simulation) {
  constexpr double kSamples = 10.0, kShareOfTheHorizon = 0.5;
  HoldTimes times{excitation.shortest_s, excitation.longest_s};
  if (times.shortest_s == 0.0) times.shortest_s = kSamples * simulation.sample_period_s;
  if (excitation.shortest_s == 0.0 && times.longest_s > 0.0)
    times.shortest_s = std::min(times.shortest_s, times.longest_s);
  if (times.longest_s == 0.0) times.longest_s = std::max(times.shortest_s, kShareOfTheHorizon * simulation.horizon_s);
  return times;
}

Eigen::MatrixXd draw_inputs(const ExcitationConfig& excitation, const SimulationConfig& simulation,
                            std::uint64_t engine_seed, std::uint64_t run, const LoggedInputs& log) {
  Eigen::MatrixXd inputs(static_cast<Eigen::Index>(excitation.low.size()), sample_count(simulation));
  Eigen::MatrixXd recorded;
  if (log.values.size() > 0) {
    RunRandom random(engine_seed, RunPurpose::kLoggedInputs, 0, run);
    const double log_s = log.time_s(log.time_s.size() - 1);
    const double latest_s = log_s >= simulation.horizon_s ? log_s - simulation.horizon_s : log_s;
    recorded = stretch_of(log, random.between(0.0, latest_s), simulation.sample_period_s, sample_count(simulation));
  }
  for (std::size_t j = 0; j < excitation.low.size(); ++j) {
    RunRandom random(engine_seed, RunPurpose::kInputs, j, run);
    const InputSignal kind = excitation.kinds[random.index(excitation.kinds.size())];
    const auto row = static_cast<Eigen::Index>(j);
    if (kind != InputSignal::kLog) {
      inputs.row(row) = SignalSource(excitation, simulation, j, random).draw(kind);
    } else if (recorded.size() > 0) {
      inputs.row(row) = recorded.row(row);
    } else {
      throw codegen::Error("inputs of the kind \"log\" are drawn from a log, and none was read");
    }
  }
  return inputs;
}

std::vector<std::pair<std::string, std::string>> describe_inputs(const ExcitationConfig& excitation,
                                                                 const Plant& plant) {
  std::vector<std::string> kinds;
  for (const InputSignal kind : excitation.kinds) kinds.emplace_back(to_name(kind));
  std::vector<std::pair<std::string, std::string>> result;
  for (std::size_t j = 0; j < plant.inputs().size(); ++j)
    result.emplace_back(plant.inputs()[j].name,
                        fmt::format("drawn within {} .. {} ({})", shortest_text(excitation.low.at(j)),
                                    shortest_text(excitation.high.at(j)), fmt::join(kinds, ", ")));
  return result;
}

}  // namespace nlo::trainer
