// SPDX-License-Identifier: MIT
#include "trainer/config/check.h"

#include <fmt/format.h>

#include <cmath>
#include <complex>

#include "codegen/error.h"
#include "trainer/base/number_text.h"
#include "trainer/config/check_plant.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/transient.h"
#include "trainer/plants/odd_symmetry.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/structures/observer_gain.h"

namespace nlo::trainer {
namespace {

class Check {
 public:
  Check(const Experiment& experiment, const Places& places) : e_(experiment), places_(places) {}

  void run() const {
    sources();
    if (e_.plant) plant_and_simulation();
    if (e_.log) log();
    observer();
    if (const auto fault = angle_fault(e_)) fail(fault->path, fault->what);
    losses();
    training();
    if (e_.training.transient != "keep") transient();
    evaluation();
  }

 private:
  static constexpr double kMostSamples = 1e7, kMostNumbers = 1e9;  // 8 GB of doubles

  [[noreturn]] void fail(const std::string& path, const std::string& what) const {
    throw codegen::Error(fmt::format("{}: {}", places_.of(path), what));
  }

  void sources() const {
    if (e_.name.empty()) fail("", "the experiment has no name; begin the file with name = \"my_observer\"");
    if (!e_.plant && !e_.log)
      fail("", "neither [plant] nor [log]; say what to learn from: a plant to simulate, or logs");
    if (e_.plant && e_.log) fail("log", "both [plant] and [log]; keep one: a plant to simulate, or logs");
    if (e_.log && places_.has("simulation")) fail("simulation", "[simulation] has no use for [log]; remove it");
  }

  void plant_and_simulation() const {
    std::size_t nx = 0;
    try {
      const auto plant = make_plant(*e_.plant);
      PlantChannels(*e_.plant, *plant);
      nx = plant->states().size();
    } catch (const codegen::Error& error) {
      fail(plant_key_named_by(error.what()), error.what());
    }
    const SimulationConfig& s = e_.simulation;
    if (const auto fault = initial_state_fault(s, nx)) fail(fault->path, fault->what);
    const double samples = s.horizon_s / s.sample_period_s;
    if (!(samples >= 1.0))
      fail("simulation.horizon_s", fmt::format("[simulation] horizon_s is {} and sample_period_s {}; the horizon must "
                                               "be the longer one",
                                               shortest_text(s.horizon_s), shortest_text(s.sample_period_s)));
    if (samples > kMostSamples || samples * s.trajectories * static_cast<double>(nx) > kMostNumbers)
      fail("simulation.horizon_s",
           fmt::format("[simulation] asks for {} trajectories of {:.3g} samples; that does not fit into memory: take a "
                       "shorter horizon, a longer sample period or fewer trajectories",
                       s.trajectories, samples));
    if (e_.training.segment_s > s.horizon_s)
      fail("training.segment_s", fmt::format("[training] segment_s is {}; it must be at most horizon_s, {}",
                                             shortest_text(e_.training.segment_s), shortest_text(s.horizon_s)));
  }

  /// make_plant says "[plant] derivative[1] ..." or "plant NAME has no parameter ...": find the line of that key.
  std::string plant_key_named_by(std::string_view message) const {
    for (const char* key : {"derivative", "output_names", "output_wraps", "output_encodings", "outputs", "input_field",
                            "state_wraps", "state_encodings", "states", "estimated", "parameters", "model"})
      if (message.starts_with(fmt::format("[plant] {}", key))) return fmt::format("plant.{}", key);
    return message.find("parameter") != std::string_view::npos ? "plant.parameters" : "plant";
  }

  void log() const {
    const LogConfig& log = *e_.log;
    if (log.columns.empty())
      fail("log", "[log] has no columns; name them: [[log.columns]] with name = \"...\" and role = \"...\"");
    for (std::size_t i = 0; i < log.columns.size(); ++i)
      if (log.columns[i].name.empty())
        fail(fmt::format("log.columns[{}]", i), "[[log.columns]] has no name; give one: name = \"...\"");
    if (log.train_files.empty())
      fail("log", "[log] has no train_files; list the logs to train on: train_files = [\"run1.csv\", \"day2/*.csv\"]");
    try {
      resolve_columns(log);
    } catch (const codegen::Error& error) {
      fail(column_named_by(error.what()), error.what());
    }
  }

  std::string column_named_by(std::string_view message) const {
    // A name can stand on two columns: the message is about the later one.
    for (std::size_t i = e_.log->columns.size(); i-- > 0;)
      if (message.starts_with(fmt::format("[[log.columns]] \"{}\"", e_.log->columns[i].name)))
        return fmt::format("log.columns[{}]", i);
    return "log";
  }

  void observer() const {
    const ObserverConfig& o = e_.observer;
    if (o.structure == "luenberger") return luenberger();
    unused_unless("luenberger", {{"state_matrix", !o.state_matrix.empty()},
                                 {"output_matrix", !o.output_matrix.empty()},
                                 {"gain", !o.gain.empty()},
                                 {"gain_poles", !o.gain_poles.empty()},
                                 {"gain_noise", !o.gain_noise.empty()}});
    if (o.structure == "general") general();
    if (o.structure == "driven_kkl") driven();
    if (o.eigenvalues.empty() && o.pairs.empty())
      fail("observer", "[observer] has no latent state; give eigenvalues = [-1.0, ...] or pairs = [[-1.0, 2.0], ...]");
    for (std::size_t i = 0; i < o.pairs.size(); ++i) {
      if (!(o.pairs[i][0] < 0.0))
        fail("observer.pairs",
             fmt::format("[observer] pairs[{}] has the real part {}; it must be < 0", i, shortest_text(o.pairs[i][0])));
      if (!(o.pairs[i][1] > 0.0))
        fail("observer.pairs", fmt::format("[observer] pairs[{}] has the imaginary part {}; it must be > 0 (its "
                                           "conjugate is meant too); a real eigenvalue belongs in eigenvalues",
                                           i, shortest_text(o.pairs[i][1])));
    }
    const double period = e_.plant ? e_.simulation.sample_period_s : e_.log->sample_period_s;
    if (!(period > 0.0)) return;
    try {
      check_latent_step(o, period);
    } catch (const codegen::Error& error) {
      fail("observer.hold", error.what());
    }
  }

  using Given = std::vector<std::pair<const char*, bool>>;

  void unused_unless(const char* structure, const Given& keys) const {
    for (const auto& [key, given] : keys)
      if (given)
        fail(fmt::format("observer.{}", key),
             fmt::format("[observer] {} belongs to structure = \"{}\"; this one is \"{}\"", key, structure,
                         e_.observer.structure));
  }

  void luenberger() const {
    const ObserverConfig& o = e_.observer;
    for (const auto& [key, given] : Given{{"eigenvalues", !o.eigenvalues.empty()},
                                          {"pairs", !o.pairs.empty()},
                                          {"clocks_s", !o.clocks_s.empty()},
                                          {"start", o.start != "zero"}})
      if (given)
        fail(fmt::format("observer.{}", key),
             fmt::format("[observer] {} has no use in a Luenberger observer, whose latent state is the estimate; "
                         "remove it",
                         key));
    const auto [nx, ny] = sizes();
    try {
      linear_part(o, static_cast<int>(nx), static_cast<int>(ny));
    } catch (const codegen::Error& error) {
      fail(observer_key_named_by(error.what()), error.what());
    }
  }

  std::string observer_key_named_by(std::string_view message) const {
    for (const char* key : {"state_matrix", "output_matrix", "gain_poles", "gain_noise", "gain"})
      if (message.starts_with(fmt::format("[observer] {}", key))) return fmt::format("observer.{}", key);
    return "observer";
  }

  /// n_x and n_y as the observer has them.
  std::pair<std::size_t, std::size_t> sizes() const {
    if (e_.plant) {
      const PlantChannels channels(*e_.plant, *make_plant(*e_.plant));
      return {channels.states().size(), channels.outputs().size()};
    }
    const LogSchema schema = resolve_columns(*e_.log);
    return {schema.state_channels.size(), schema.output_channels.size()};
  }

  /// How many quantities are measured: an angle as sine and cosine is one.
  std::size_t sensors() const {
    return e_.plant ? make_plant(*e_.plant)->outputs().size() : resolve_columns(*e_.log).outputs.size();
  }

  void general() const {
    const ObserverConfig& o = e_.observer;
    if (!o.clocks_s.empty())
      fail("observer.clocks_s", "[observer] clocks_s are rows of D; the general observer has none: remove them");
    if (o.features != "latent")
      fail("observer.features",
           fmt::format("[observer] features is \"{}\", and G of the general observer reads z alone; "
                       "remove it",
                       o.features));
    starts_at_zero("the general observer");
  }

  void driven() const {
    if (!e_.plant || make_plant(*e_.plant)->nu() == 0)
      fail("observer.structure",
           "[observer] structure = \"driven_kkl\" needs a plant with inputs; name them in [plant] "
           "inputs, or take structure = \"kkl\"");
    if (!e_.loss.needs_forward_map())
      fail("observer.structure",
           "[observer] structure = \"driven_kkl\" flies T, and no loss trains it; set [loss] "
           "map_consistency = 1.0");
  }

  void starts_at_zero(const char* what) const {
    if (e_.observer.start != "zero")
      fail("observer.start",
           fmt::format("[observer] start is \"{}\", and {} starts from z = 0; remove it", e_.observer.start, what));
  }

  void losses() const {
    const LossConfig& l = e_.loss;
    const bool kkl = e_.observer.structure == "kkl" || e_.observer.structure == "driven_kkl";
    if (!kkl) {
      for (const auto& [key, weight] : {std::pair{"map_consistency", l.map_consistency},
                                        {"reconstruction", l.reconstruction},
                                        {"pde_residual", l.pde_residual},
                                        {"eigenvalue_penalty", l.eigenvalue_penalty}})
        if (weight > 0.0)
          fail(fmt::format("loss.{}", key), fmt::format("[loss] {} is about D and T of a KKL observer; structure = "
                                                        "\"{}\" has none",
                                                        key, e_.observer.structure));
    }
    if (l.state_error + l.terminal + l.map_consistency + l.reconstruction + l.pde_residual == 0.0)
      fail("loss", "[loss] every weight is zero: there is nothing to learn; leave state_error at 1");
    if (e_.uses_forward_map() && !e_.observer.clocks_s.empty())
      fail("observer.clocks_s",
           "[observer] clocks_s are no function of the state, so T cannot give them; remove them, or "
           "the losses of T");
    if (l.pde_residual > 0.0 && e_.log)
      fail("loss.pde_residual", "[loss] pde_residual needs f and h; logs know no plant: remove it");
    const bool box = l.collocation == "box";
    for (const auto& [key, corner] :
         {std::pair{"collocation_low", &l.collocation_low}, {"collocation_high", &l.collocation_high}}) {
      if (!box && !corner->empty())
        fail(fmt::format("loss.{}", key), fmt::format("[loss] {} needs collocation = \"box\"", key));
      const std::size_t nx = !box ? 0 : e_.plant ? make_plant(*e_.plant)->states().size() : sizes().first;
      if (corner->size() != nx)
        fail(fmt::format("loss.{}", key),
             fmt::format("[loss] {} has {} numbers; the plant has {} states", key, corner->size(), nx));
    }
    for (std::size_t i = 0; i < l.collocation_low.size(); ++i)
      if (!(l.collocation_low[i] < l.collocation_high[i]))
        fail("loss.collocation_high",
             fmt::format("[loss] collocation_high[{0}] is {1}; it must be above collocation_low[{0}], {2}", i,
                         shortest_text(l.collocation_high[i]), shortest_text(l.collocation_low[i])));
  }

  void training() const {
    const TrainingConfig& t = e_.training;
    if (t.gradient != "automatic") starts_at_zero("a roll-out by gradient = \"backprop\" or \"adjoint\"");
    if (t.early_share > 0.0 && t.early_s == 0.0)
      fail("training.early_share", "[training] early_share needs early_s, the time it speaks of; set both or none");
    if (t.noise_level_max > 0.0 && t.noise.none())
      fail("training.noise_level_max",
           "[training] noise_level_max scales the noise, and there is none; set noise = \"gaussian:1\" or remove it");
    try {
      check_noise(t.noise, sensors());
    } catch (const codegen::Error& error) {
      fail("training.noise", fmt::format("[training] {}", error.what()));
    }
    if (t.mirror) mirror();
  }

  void mirror() const {
    const auto refuse = [&](const std::string& why) { fail("training.mirror", "[training] mirror = true: " + why); };
    if (e_.plant)
      if (const auto found = odd_counterexample(*make_plant(*e_.plant), e_.simulation))
        refuse(fmt::format("{}; set mirror = false", *found));
    if (!e_.log) return;
    for (const ColumnConfig& column : e_.log->columns) {
      if (column.role != ColumnRole::kOutput && column.role != ColumnRole::kState) continue;
      if (!column.odd)
        refuse(
            fmt::format("the column {} is declared odd = false, so the mirror image of a log is no run of this "
                        "rig; set mirror = false",
                        column.name));
    }
  }

  /// It lies at the start of whole trajectories: what draws samples elsewhere contradicts that.
  void transient() const {
    const TrainingConfig& t = e_.training;
    if (t.transient == "backward" && e_.log)
      fail("training.transient",
           "[training] transient = \"backward\" simulates the plant's past, and logs have no plant; use \"drop\"");
    if (t.segment_s > 0.0)
      fail("training.segment_s", fmt::format("[training] segment_s starts the filter anew inside of a trajectory, past "
                                             "what transient = \"{}\" keeps out; set segment_s = 0, or transient = "
                                             "\"keep\"",
                                             t.transient));
    if (t.early_share > 0.0)
      fail("training.early_share", fmt::format("[training] early_share asks for more of the transient that transient = "
                                               "\"{}\" keeps out; remove one of them",
                                               t.transient));
    const double t_c = transient_time_s(e_.observer, t.transient_factor);
    if (!std::isfinite(t_c))
      fail("training.transient",
           fmt::format("[training] transient = \"{}\" is of a filter by its eigenvalues, and this "
                       "observer has none; set transient = \"keep\"",
                       t.transient));
    if (!e_.plant) return;
    const SimulationConfig& s = e_.simulation;
    const std::string length = fmt::format("the transient lasts {:.4g} s (transient_factor / min |Re lambda|)", t_c);
    if (t.transient == "drop" && t_c >= s.horizon_s)
      fail("training.transient", fmt::format("[training] transient = \"drop\" leaves nothing of the horizon of {} s: "
                                             "{}; take faster eigenvalues or a longer horizon",
                                             shortest_text(s.horizon_s), length));
    const double samples = (t_c + s.horizon_s) / s.sample_period_s;
    if (t.transient == "backward" &&
        (samples > kMostSamples ||
         samples * s.trajectories * static_cast<double>(make_plant(*e_.plant)->nx()) > kMostNumbers))
      fail("training.transient",
           fmt::format("[training] transient = \"backward\" makes trajectories of {:.3g} samples, "
                       "which do not fit into memory: {}; take faster eigenvalues",
                       samples, length));
  }

  void evaluation() const {
    const auto& windows = e_.evaluation.windows;
    const auto refuse = [&](const EvaluationWindow& window, const std::string& what) {
      fail("evaluation.windows", fmt::format("[evaluation] window \"{}\" {}", window.name, what));
    };
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const EvaluationWindow& window = windows[i];
      if (window.name == "all") refuse(window, "is the whole run, which is always told; give it another name");
      for (std::size_t j = 0; j < i; ++j)
        if (windows[j].name == window.name) refuse(window, "stands there twice; give one of them another name");
      if (!(window.from_s < window.to_s))
        refuse(window, fmt::format("runs from {} s to {} s; from_s must be the smaller one",
                                   shortest_text(window.from_s), shortest_text(window.to_s)));
    }
  }

  const Experiment& e_;
  const Places& places_;
};

}  // namespace

std::string Places::of(const std::string& path) const {
  for (std::string at = path; !at.empty();) {
    if (const auto found = places_.find(at); found != places_.end()) return found->second;
    const auto dot = at.rfind('.');
    at = dot == std::string::npos ? "" : at.substr(0, dot);
  }
  return filename_;
}

void check_latent_step(const ObserverConfig& observer, double sample_period_s) {
  if (observer.hold != "rk4") return;
  const auto check = [&](std::complex<double> lambda, const std::string& shown) {
    const auto x = lambda * sample_period_s;
    const auto factor = 1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0)));
    if (std::abs(factor) < 1.0) return;
    throw codegen::Error(
        fmt::format("unstable step: hold = \"rk4\" multiplies the latent state of eigenvalue {} by {:.3g} in every "
                    "sample of {} s; take a smaller sample period (|lambda| h < 2.78), or hold = \"first_order\"",
                    shown, std::abs(factor), shortest_text(sample_period_s)));
  };
  for (const double lambda : observer.eigenvalues) check(lambda, shortest_text(lambda));
  for (const auto& [re, im] : observer.pairs)
    check({re, im}, fmt::format("{} +- {}i", shortest_text(re), shortest_text(im)));
}

void check_experiment(const Experiment& experiment, const Places& places) {
  Check(experiment, places).run();
}

}  // namespace nlo::trainer
