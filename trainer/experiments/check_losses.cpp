// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

namespace {

/// Checks the requirements of a term with a weight on the observer and on the data.
void check_term(const LossTerm& term, const Experiment& e) {
  const std::string key = fmt::format("loss.{}", term.name);
  if (term.needs_eigenvalues && !structure_of(e.observer).has_eigenvalues())
    throw KeyError(key, fmt::format("[loss] {} needs D and T of a KKL observer, which structure = \"{}\" does not have",
                                    term.name, e.observer.structure));
  if (term.needs_equations && e.log)
    throw KeyError(
        key, fmt::format("[loss] {} needs f and h of a plant, but this experiment has logs; remove it", term.name));
}

/// Checks that the box of collocation points is given and has an interval for each state of the plant.
void check_collocation(const Experiment& e) {
  const LossConfig& l = e.loss;
  const bool box = l.collocation == EquationPoints::kBox;
  for (const auto& [key, corner] :
       {std::pair{"collocation_low", &l.collocation_low}, {"collocation_high", &l.collocation_high}}) {
    if (!box && !corner->empty())
      throw KeyError(fmt::format("loss.{}", key), fmt::format("[loss] {} needs collocation = \"box\"", key));
    const std::size_t nx = !box      ? 0
                           : e.plant ? make_plant(*e.plant)->states().size()
                                     : static_cast<std::size_t>(observer_channels(e).states);
    if (corner->size() != nx)
      throw KeyError(fmt::format("loss.{}", key),
                     fmt::format("[loss] {} has {} numbers; the plant has {} states", key, corner->size(), nx));
  }
  for (std::size_t i = 0; i < l.collocation_low.size(); ++i)
    if (!(l.collocation_low[i] < l.collocation_high[i]))
      throw KeyError("loss.collocation_high",
                     fmt::format("[loss] collocation_high[{0}] is {1}; it must be above collocation_low[{0}], {2}", i,
                                 shortest_text(l.collocation_high[i]), shortest_text(l.collocation_low[i])));
}

}  // namespace

void check_losses(const Experiment& e) {
  bool learns = false;
  for (const LossTerm& term : loss_terms()) {
    if (!(e.loss.weight(term.name) > 0.0)) continue;
    check_term(term, e);
    learns = learns || !term.is_regulariser();
  }
  if (!learns) throw KeyError("loss", "[loss] every weight is zero, so there is nothing to learn; set state_error = 1");
  if (structure_of(e.observer).flies_forward_map() && !needs_forward_map(e.loss))
    throw KeyError("observer.structure",
                   fmt::format("[observer] structure = \"{}\" needs T in flight, but no loss trains it; set [loss] "
                               "map_consistency = 1.0",
                               e.observer.structure));
  if (uses_forward_map(e) && !e.observer.clocks_s.empty())
    throw KeyError("observer.clocks_s",
                   "[observer] clocks_s: clocks are not functions of the state, so T cannot return them; remove "
                   "clocks_s, or the losses of T");
  if (uses_forward_map(e) && observer_channels(e).read_inputs > 0)
    throw KeyError("loss",
                   "[loss] the losses of T need a latent state that is a function of the state, but with inputs it "
                   "also depends on them; remove the losses of T, or the inputs");
  check_collocation(e);
}

}  // namespace nlo::trainer
