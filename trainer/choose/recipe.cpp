// SPDX-License-Identifier: MIT
#include "trainer/choose/recipe.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/draws.h"
#include "trainer/base/number_text.h"
#include "trainer/base/quantile.h"
#include "trainer/choose/mode_banks.h"
#include "trainer/choose/pilot.h"
#include "trainer/choose/readout_probe.h"
#include "trainer/choose/resonances.h"
#include "trainer/choose/structure_rivals.h"
#include "trainer/data/evaluation_windows.h"
#include "trainer/plants/odd_plant.h"
#include "trainer/plants/plant_form.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/kkl_family.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/trainable_structure.h"
#include "trainer/structures/unit_settings.h"

namespace nlo::trainer {
namespace {

/// Returns true if runs and their mirror images are equally likely. Otherwise mirror would add data where the plant
/// never is.
bool starts_evenly(const Experiment& e) {
  const auto even = [](const std::vector<double>& low, const std::vector<double>& high) {
    for (std::size_t i = 0; i < low.size() && i < high.size(); ++i)
      if (low[i] != -high[i]) return false;
    return true;
  };
  const SimulationConfig& s = e.simulation;
  return s.initial_distribution == InitialDistribution::kUniform && !s.initial_low.empty() &&
         even(s.initial_low, s.initial_high) && (!e.excitation || even(e.excitation->low, e.excitation->high));
}

constexpr double kSamplesOfPlants = 6e5;  ///< sum over all trajectories
constexpr int kMostFeatures = 40;         ///< largest number of rows of z of all channels

std::vector<double> run_lengths_s(const Dataset& data) {
  std::vector<double> lengths;
  for (const Trajectory& run : data.trajectories) lengths.push_back(run.time_s(run.samples() - 1) - run.time_s(0));
  return lengths;
}

/// Returns the longest time constant of a derived mode [s]. A run must be at least as long, and all runs together five
/// times as long. A single log shows a slower mode too few times to fit it. Many short runs show it at each start.
double longest_time_constant_s(const std::vector<double>& run_lengths) {
  constexpr double kTimesInAll = 5.0;
  const double all = std::accumulate(run_lengths.begin(), run_lengths.end(), 0.0);
  return std::min(value_at_rank(run_lengths, 0.5), all / kTimesInAll);
}

/// The readings of an observer with a bank, and its start.
struct Reading {
  FeatureSet features = FeatureSet::kLatentAndOutput;
  LatentStart start = LatentStart::kSteady;
  Hold input_hold = Hold::kZeroOrder;
};

struct Choice {
  ModeBank bank;
  Reading reading;
  ReadoutError error;
  double value() const {
    constexpr double kRow = 0.002;  // a further row must lower every error by 0.2 %
    return error.mean_log() + kRow * error.rows;
  }
};

/// Returns the experiment with the default structure, a linear latent system. Its modes give the time scales of the
/// data for every structure.
Experiment with_linear_latent(Experiment e, double sample_period_s) {
  if (const ObserverConfig linear; e.observer.structure != linear.structure)
    structure_of(linear).adopt(e, sample_period_s);
  return e;
}

class Deriver {
 public:
  Deriver(const DraftExperiment& draft, const Dataset& training, const Dataset& validation)
      : draft_(draft),
        for_data_(experiment_for_data(draft)),
        base_(with_linear_latent(for_data_, training.sample_period_s)),
        data_(training),
        validation_(validation),
        period_s_(training.sample_period_s),
        length_s_(value_at_rank(run_lengths_s(training), 0.5)) {
    set("observer.output_injection", base_.observer.output_injection, Injection::kUnitGain);
    if (base_.log) set("observer.learn_eigenvalues", base_.observer.learn_eigenvalues, false);
    set("inverse_map.linear_path", base_.inverse_map.linear_path, true);
    set("loss.scale", base_.loss.scale, ErrorScale::kNormalised);
  }

  Recipe run() {
    if (is_filter(for_data_)) return with_units({period_s_, length_s_, 0.0}, 0.0);
    const std::vector<Choice> finalists = choose();
    const DataScales scales{period_s_, length_s_, finalists.front().bank.slowest()};
    if (!is_linear_latent()) return with_units(scales, settled_from_s(finalists.front().bank));
    std::vector<Experiment> experiments;
    for (const Choice& choice : finalists) {
      Experiment e = with(choice.bank, choice.reading);
      complete(e, choice);
      experiments.push_back(checked(e, base_));
    }
    const std::vector<Rival> rivals = structure_rivals(draft_, for_data_, scales);
    if (finalists.size() == 1 && rivals.empty() && !may_read_clock_products())
      return {experiments.front(), text_of(experiments.front(), finalists.front())};

    const Pilots pilots(base_, data_, validation_, settled_from_s(finalists.front().bank));
    std::vector<double> errors;
    for (const Experiment& e : experiments) errors.push_back(pilots.error(e, kPilotSteps));
    const auto best = static_cast<std::size_t>(std::min_element(errors.begin(), errors.end()) - errors.begin());
    Piloted linear{experiments[best], errors[best]};
    std::string told = fmt::format("         after {} steps the best of {} has the error {:.3g}", kPilotSteps,
                                   errors.size(), linear.error);
    if (may_read_clock_products()) linear = better_with_products(linear, pilots, told);
    Piloted chosen = best_structure(linear, rivals, pilots, told);
    if (pilots.holds_out_a_part() && !given("training.steps"))
      chosen.experiment = with_fewer_steps(chosen.experiment, pilots, told);
    return {chosen.experiment, text_of(linear.experiment, finalists[best]) + told + "\n"};
  }

 private:
  static constexpr int kPilotSteps = 500;
  /// A more complex observer must lower the error by a tenth. A linear latent system is the fastest to train and simple
  /// in flight; a filter needs no training.
  static constexpr double kWorthIt = 0.9;

  struct Piloted {
    Experiment experiment;
    double error = 0.0;  ///< Pilots::error()
  };

  bool is_linear_latent() const { return for_data_.observer.structure == base_.observer.structure; }

  /// Returns the recipe of a draft that names a structure with units. A prior whose units are left open keeps them if
  /// they are worth it.
  ///   settled_from_s  end of the transient [s]; only read if the units are left open
  Recipe with_units(const DataScales& scales, double settled_from_s) const {
    const TrainableStructure& structure = structure_of(for_data_.observer);
    Experiment e = with_structure(draft_, for_data_, structure, scales);
    std::string tried;
    if (structure.has_known_equations() && !given("observer.units")) {
      const Pilots pilots(base_, data_, validation_, settled_from_s);
      const Experiment filter = with_structure(draft_, for_data_, structure, scales, false);
      const double alone = pilots.error(filter, 0), corrected = pilots.error(e, kPilotSteps);
      tried = fmt::format("         after {} steps its error is {:.3g}, that of the filter alone {:.3g}\n", kPilotSteps,
                          corrected, alone);
      if (!(corrected < kWorthIt * alone)) e = filter;
    }
    const UnitSettings& units = e.observer.own.get<UnitSettings>();
    std::string text = fmt::format("derived  structure \"{}\"", structure.name());
    text += units.units == 0 ? " without units: an extended Kalman filter, tuned on the training data\n"
                             : fmt::format(": {} units, at first with rates from {} to {} 1/s\n", units.units,
                                           shortest_text(units.rates.front()), shortest_text(units.rates.back()));
    text += tried;
    text += fmt::format(
        "         {}all of it: derived.toml\n",
        units.units == 0 ? ""
                         : fmt::format("T* {}, {} steps{}; ", map_text(e.inverse_map), e.training.steps, data_text(e)));
    if (const std::string reason = misleading_validation(structure, for_data_); !reason.empty())
      text += fmt::format("warning: in flight a prior may be worse than its validation: {}\n", reason);
    return {std::move(e), std::move(text)};
  }

  /// Returns the end of the transient of an observer with these modes [s], as its evaluation determines it.
  double settled_from_s(const ModeBank& bank) const {
    const double from_s = trainer::settled_from_s(evaluation_windows(base_.evaluation, bank.slowest(), length_s_));
    return from_s > 0.0 ? from_s : 0.2 * length_s_;
  }

  /// Uses products with clocks if they lower the error enough. `told` gets a text about it.
  Piloted better_with_products(const Piloted& plain, const Pilots& pilots, std::string& told) const {
    // Products make the first layer wider, which costs time in every step of the loop.
    constexpr double kWorthAFirstLayer = 0.95;
    Piloted products{with_clock_products(plain.experiment), 0.0};
    products.error = pilots.error(products.experiment, kPilotSteps);
    const bool better = products.error < kWorthAFirstLayer * plain.error;
    told += fmt::format(", with products of clocks {:.3g}{}", products.error, better ? ": taken" : "");
    return better ? products : plain;
  }

  /// Uses another structure if it lowers the error enough. `told` gets the errors of all, and the reason why one was
  /// not tried.
  Piloted best_structure(const Piloted& linear, const std::vector<Rival>& rivals, const Pilots& pilots,
                         std::string& told) const {
    Piloted best = linear;
    double filter_alone = std::numeric_limits<double>::infinity();
    std::string not_tried;
    const auto tell_not_tried = [&not_tried](const Rival& rival, std::string_view reason) {
      const std::string line =
          fmt::format("\n         structure \"{}\" was not tried: {}", rival.experiment.observer.structure, reason);
      if (!not_tried.ends_with(line)) not_tried += line;  // the filter and the prior have the same reason
    };
    for (const Rival& rival : rivals) {
      if (!rival.not_tried.empty()) {
        tell_not_tried(rival, rival.not_tried);
        continue;
      }
      try {
        const double error =
            pilots.error(rival.experiment, std::min(kPilotSteps, rival.experiment.training.steps / 10));
        const bool filters = is_filter(rival.experiment);
        told += fmt::format(", {} {:.3g}", filters ? "filter" : rival.experiment.observer.structure, error);
        if (filters) filter_alone = error;
        // Corrections must be worth it beside the filter alone, even if another structure is ahead of both.
        const bool corrects = structure_of(rival.experiment.observer).has_known_equations() && !filters;
        if (corrects && !(error < kWorthIt * filter_alone)) continue;
        if (error < std::min(kWorthIt * linear.error, best.error)) best = {rival.experiment, error};
      } catch (const codegen::Error& reason) {
        tell_not_tried(rival, reason.what());
      }
    }
    if (best.experiment.observer.structure != linear.experiment.observer.structure)
      told += fmt::format(": structure \"{}\"{} is chosen", best.experiment.observer.structure,
                          is_filter(best.experiment) ? " with units = 0" : "");
    told += not_tried;
    return best;
  }

  /// A single log is soon overfitted: its network has seen all samples, many of them alike, in each few steps.
  Experiment with_fewer_steps(Experiment e, const Pilots& pilots, std::string& told) const {
    TrainingConfig& t = e.training;
    const int steps = pilots.best_steps(e);
    if (steps == t.steps) return e;
    told += fmt::format("\n         {} steps: more of them raise the error on the last quarter of the log", steps);
    t.steps = steps;
    set("training.validate_every", t.validate_every, std::clamp(steps / 12, 1, t.validate_every));
    return checked(e, base_);
  }

  bool given(std::string_view key) const { return draft_.given.has(std::string(key)); }

  template <class T>
  void set(std::string_view key, T& value, T derived) const {
    if (!given(key)) value = std::move(derived);
  }

  Experiment with(const ModeBank& bank, const Reading& reading) const {
    Experiment e = base_;
    ObserverConfig& o = e.observer;
    o.eigenvalues = bank.real;
    o.pairs = bank.pairs;
    set("observer.features", o.features, reading.features);
    set("observer.start", o.start, reading.start);
    set("observer.input_hold", o.input_hold, reading.input_hold);
    if (!given("observer.clocks_s")) {
      const double slow_s = std::min(1.0 / bank.slowest(), 0.3 * length_s_);
      o.clocks_s = {rounded(std::max(0.15 * slow_s, period_s_)), rounded(std::max(0.8 * slow_s, 4.0 * period_s_))};
    }
    return e;
  }

  /// Products with clocks are learned from the starts of runs. Logs have few of them: with four logs of a pendulum, the
  /// transient became worse.
  bool may_read_clock_products() const {
    return structure_of(base_.observer).may_read_clock_products() && !base_.log && !given("observer.clocks_s") &&
           !given("observer.clock_products");
  }

  /// Returns the same observer with a clock for each time scale of D, whose T* reads products with them.
  Experiment with_clock_products(Experiment e) const {
    constexpr std::size_t kMostClocks = 4;
    constexpr double kOneScale = 1.6;  // ratio of time constants up to which one clock is enough
    ObserverConfig& o = e.observer;
    std::vector<double> times_s;
    for (const double lambda : o.eigenvalues) times_s.push_back(-1.0 / lambda);
    for (const auto& [re, im] : o.pairs) times_s.push_back(-1.0 / re);
    std::ranges::sort(times_s, std::greater<>());
    o.clocks_s.clear();
    for (const double time_s : times_s)
      if (time_s > 2.0 * period_s_ && o.clocks_s.size() < kMostClocks &&
          (o.clocks_s.empty() || o.clocks_s.back() > kOneScale * time_s))
        o.clocks_s.push_back(rounded(time_s));
    if (o.clocks_s.empty()) o.clocks_s = {rounded(2.0 * period_s_)};
    o.own.set<KklConfig>().clock_products = ClockProductSet::kAll;
    return checked(e, base_);
  }

  /// Returns true if the checks allow an observer that reads and starts in this way.
  bool allowed(const ModeBank& bank, const Reading& reading) const {
    try {
      (void)parse_experiment(format_experiment(with(bank, reading)), "a candidate");
      return true;
    } catch (const codegen::Error&) {
      return false;
    }
  }

  /// Returns the readings that the draft leaves open, the usual one first.
  std::vector<Reading> readings(const ModeBank& bank) const {
    const NoiseMixture noise = base_.training.all_noise();
    const bool quiet =
        std::all_of(noise.parts.begin(), noise.parts.end(), [](const NoiseConfig& n) { return n.none(); });
    std::vector<Reading> all;
    for (const FeatureSet features :
         {FeatureSet::kLatentAndOutput, FeatureSet::kLatentMinusOutput, FeatureSet::kLatent})
      for (const LatentStart start : {LatentStart::kSteady, LatentStart::kZero})
        for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
          if (given("observer.features") && features != base_.observer.features) continue;
          if (given("observer.start") && start != base_.observer.start) continue;
          // z = 0 averages the noise of the first sample. Without noise it only discards the information of that
          // sample.
          if (start == LatentStart::kZero && quiet && !all.empty()) continue;
          // The simulation of a plant, or the search for delays, determines how inputs act.
          const bool open = base_.log && data_.reads_inputs && !given("observer.input_hold");
          if (open ? false : hold != base_.observer.input_hold) continue;
          const Reading reading{features, start, hold};
          if (features == FeatureSet::kLatent && !given("observer.features") && !all.empty()) continue;
          if (allowed(bank, reading)) all.push_back(reading);
        }
    return all;
  }

  /// Returns the best choice of each form, the best form first.
  std::vector<Choice> choose() {
    constexpr int kFewFeatures = 64, kFewSamples = 6000, kManyFeatures = 256, kManySamples = 16000;
    constexpr std::size_t kFinalists = 4;
    ReadoutProbe probe(base_, data_);
    const int most_rows = kMostFeatures / std::max(1, static_cast<int>(data_.readings().size()));
    const double longest_s = longest_time_constant_s(run_lengths_s(data_));
    const auto too_slow = [&](const ModeBank& bank) { return bank.slowest() * longest_s < 1.0; };
    std::vector<ModeBank> banks = mode_banks(period_s_, length_s_, most_rows);
    std::erase_if(banks, too_slow);
    if (banks.empty())
      throw codegen::Error(
          fmt::format("runs of {} s with a sample each {} s are too short to derive eigenvalues from; give longer or "
                      "more runs, or [observer] eigenvalues",
                      shortest_text(length_s_), shortest_text(period_s_)));
    const std::vector<Reading> ways = readings(banks.front());
    if (ways.empty())  // this throws an error with the reason
      (void)parse_experiment(format_experiment(with(banks.front(), {})), "what was derived");

    const auto better = [](const Choice& a, const Choice& b) { return a.value() < b.value(); };
    const auto best_of_forms = [&](std::vector<Choice> all) {
      std::stable_sort(all.begin(), all.end(), better);
      std::vector<Choice> best;
      for (Choice& choice : all) {
        const auto same = [&](const Choice& other) { return other.bank.form == choice.bank.form; };
        if (best.size() < kFinalists && std::none_of(best.begin(), best.end(), same)) best.push_back(std::move(choice));
      }
      return best;
    };
    std::vector<Choice> rough, fine;
    for (const ModeBank& bank : banks)
      rough.push_back({bank, ways.front(), probe.error(with(bank, ways.front()), kFewFeatures, kFewSamples)});
    const auto measure = [&](const ModeBank& bank, const Reading& way) {
      fine.push_back({bank, way, probe.error(with(bank, way), kManyFeatures, kManySamples)});
    };
    for (const Choice& choice : best_of_forms(rough))
      for (const Reading& way : ways) measure(choice.bank, way);
    for (const Choice& choice : best_of_forms(fine))
      for (const double faster : {0.75, 1.33}) {
        const ModeBank bank = choice.bank.scaled(faster);
        if (!too_slow(bank)) measure(bank, choice.reading);
      }
    tried_ = rough.size() + fine.size();
    std::vector<Choice> best = best_of_forms(fine);
    const ModeBank resonant =
        with_resonances(best.front().bank, period_s_, longest_s, most_rows, [&](const ModeBank& bank) {
          ++tried_;
          return probe.error(with(bank, best.front().reading), 0, kFewSamples).mean_log();
        });
    if (resonant.rows() > best.front().bank.rows()) {
      measure(resonant, best.front().reading);
      if (fine.back().value() < best.front().value()) {  // this value includes the curved readout and all samples
        best.insert(best.begin(), fine.back());
        best.resize(std::min(best.size(), kFinalists));
      }
    }
    return best;
  }

  /// Returns the smallest ratio, over the states, of the error of a curved readout to the error of a linear one.
  static double curvature(const ReadoutError& error) {
    double least = 1.0;
    for (std::size_t i = 0; i < error.linear.size(); ++i)
      least = std::min(least, error.curved[i] / std::max(error.linear[i], 1e-9));
    return least;
  }

  void complete(Experiment& e, const Choice& choice) const {
    const double slow_s = 1.0 / choice.bank.slowest(), share = curvature(choice.error);
    const bool wide = share < 0.6;
    InverseMapConfig& map = e.inverse_map;
    TrainingConfig& t = e.training;
    set("inverse_map.hidden", map.hidden, wide ? std::vector<int>{48, 48} : std::vector<int>{32, 32});
    set("inverse_map.activation", map.activation, std::string("silu"));
    if (e.log && choice.bank.resonances > 0) {
      // Learning adjusts the last per cent of a resonance's frequency and damping, which on Silverbox is a third of the
      // error. With the learning rate of the network, a pair with little damping would lose its resonance.
      set("observer.learn_eigenvalues", e.observer.learn_eigenvalues, true);
      set("training.eigenvalue_learning_rate", t.eigenvalue_learning_rate, 1e-3);
    }
    if (e.log) set("inverse_map.ridge", map.ridge, std::clamp(choice.error.ridge, 1e-6, 1e-2));
    set("training.steps", t.steps, e.log ? 5000 : wide ? 8000 : 4000);
    set("training.trajectories_per_step", t.trajectories_per_step, 32);
    set("training.samples_per_step", t.samples_per_step, 4096);
    set("training.learning_rate", t.learning_rate, 5e-3);
    set("training.schedule", t.schedule, std::string("cosine"));
    set("training.ema", t.ema, 0.998);
    set("training.validate_every", t.validate_every, std::clamp(t.steps / 20, 1, 200));
    const bool keeps = t.transient == Transient::kKeep;
    if (e.log) {
      // With decoupled decay, weights shrink by e^-(decay rate steps). After e^-7 little more than the linear path
      // remains.
      const double shrinkage = share < 0.7 ? 0.1 : share < 0.9 ? 1.0 : 7.0;
      set("training.weight_decay", t.weight_decay, rounded(2.0 * shrinkage / (t.learning_rate * t.steps)));
      if (keeps)
        set("training.segment_s", t.segment_s, rounded(std::max({length_s_ / 4.0, 5.0 * slow_s, 300.0 * period_s_})));
    } else if (keeps && !given("training.early_share") && !given("training.early_s")) {
      t.early_s = rounded(std::min(4.0 * slow_s, 0.25 * length_s_));
      t.early_share = 0.25;
    }
  }

  std::string text_of(const Experiment& e, const Choice& choice) const {
    const ObserverConfig& o = e.observer;
    std::string modes, states;
    for (const auto& [re, im] : o.pairs)
      modes += fmt::format("{}{}+-{}i", modes.empty() ? "" : ", ", shortest_text(re), shortest_text(im));
    for (const double lambda : o.eigenvalues)
      modes += fmt::format("{}{}", modes.empty() ? "" : ", ", shortest_text(lambda));
    for (std::size_t i = 0; i < data_.states.size(); ++i)
      states += fmt::format("{}{} {:.3g}", i == 0 ? "" : ", ", data_.states[i].name,
                            std::min(choice.error.linear[i], choice.error.curved[i]));
    return fmt::format(
        "derived  eigenvalues {} 1/s, features {}{}, start {}: the best of {} that were measured\n"
        "         expected error over deviation, before training: {}\n"
        "         T* {}, {} steps{}; all of it: derived.toml\n",
        modes, to_name(o.features),
        o.own.get<KklConfig>().clock_products == ClockProductSet::kNone ? "" : " and their products with clocks",
        to_name(o.start), tried_, states, map_text(e.inverse_map), e.training.steps, data_text(e));
  }

  static std::string map_text(const InverseMapConfig& map) {
    return fmt::format("{} {}", fmt::join(map.hidden, " x "), map.activation);
  }

  static std::string data_text(const Experiment& e) {
    if (e.log)
      return fmt::format(" of {} s segments, weight decay {}", shortest_text(e.training.segment_s),
                         shortest_text(e.training.weight_decay));
    return fmt::format(" on {} trajectories{}", e.simulation.trajectories,
                       e.training.mirror ? " and their mirror images" : "");
  }

  const DraftExperiment& draft_;
  Experiment for_data_;  ///< experiment_for_data()
  Experiment base_;      ///< for_data_ with a linear latent system
  const Dataset& data_;
  const Dataset& validation_;
  double period_s_, length_s_;
  std::size_t tried_ = 0;
};

}  // namespace

Experiment experiment_for_data(const DraftExperiment& draft) {
  Experiment e = draft.experiment;
  if (!e.plant) return e;
  if (!draft.given.has("simulation.trajectories")) {
    const double samples = e.simulation.horizon_s / e.simulation.sample_period_s;
    e.simulation.trajectories = static_cast<int>(rounded(std::clamp(kSamplesOfPlants / samples, 200.0, 2000.0)));
  }
  const auto plant = make_plant(*e.plant);
  if (!draft.given.has("training.mirror"))
    e.training.mirror = starts_evenly(e) && !mirror_counterexample(*plant, odd_channels(*plant, e.plant->even),
                                                                   e.simulation, e.excitation.has_value());
  return e;
}

Recipe derive_recipe(const DraftExperiment& draft, const Dataset& training, const Dataset& validation) {
  return Deriver(draft, training, validation).run();
}

}  // namespace nlo::trainer
