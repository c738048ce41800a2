// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {

void check_losses(const Experiment& e) {
  const LossConfig& l = e.loss;
  if (!structure_of(e.observer).has_eigenvalues()) {
    for (const auto& [key, weight] : {std::pair{"map_consistency", l.map_consistency},
                                      {"reconstruction", l.reconstruction},
                                      {"pde_residual", l.pde_residual},
                                      {"eigenvalue_penalty", l.eigenvalue_penalty}})
      if (weight > 0.0)
        throw KeyError(fmt::format("loss.{}", key),
                       fmt::format("[loss] {} is about D and T of a KKL observer; structure = "
                                   "\"{}\" has none",
                                   key, e.observer.structure));
  }
  if (l.state_error + l.terminal + l.map_consistency + l.reconstruction + l.pde_residual == 0.0)
    throw KeyError("loss", "[loss] every weight is zero: there is nothing to learn; leave state_error at 1");
  if (uses_forward_map(e) && !e.observer.clocks_s.empty())
    throw KeyError("observer.clocks_s",
                   "[observer] clocks_s are no function of the state, so T cannot give them; remove them, or "
                   "the losses of T");
  if (l.pde_residual > 0.0 && e.log)
    throw KeyError("loss.pde_residual", "[loss] pde_residual needs f and h; logs know no plant: remove it");
  const bool box = l.collocation == "box";
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

}  // namespace nlo::trainer
