// SPDX-License-Identifier: MIT
#include "trainer/reproduce/reproduced_items.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/reproduce/analyses.h"

namespace nlo::trainer::reproduction {

std::span<const Item> items() {
  static const std::vector<Item> kItems = {
      {"figure-luen-like",
       "example1",
       "Example 1: the Luenberger-like observer",
       "luen-like",
       "The observer performs well from an arbitrary initial condition; its error stabilises after about 5 s.",
       {"example1", "example1_gradient_descent"},
       20.0,
       luenberger_like},
      {"table1",
       "example2",
       "Table 1: errors of learned observers of Van der Pol",
       "vanderpol-rmse",
       "Without noise, fixed fast eigenvalues have the smallest error; with noise, they have by far the largest. In "
       "both rows with noise, the observers whose D is learned have the smallest errors, first the one trained with "
       "noise, then the regularised one.",
       {"van_der_pol_baseline_fast", "van_der_pol_baseline_mixed", "van_der_pol_baseline_slow", "van_der_pol_noise",
        "van_der_pol_regularised"},
       30.0,
       table_1},
      {"table2",
       "example2",
       "Table 2: only the largest eigenvalue changes",
       "vanderpol-rmse-add",
       "The columns of Table 1 with fixed D are repeated. If only the largest eigenvalue is moved from -5 to -0.1, the "
       "error grows without noise and falls with uniform noise.",
       {"van_der_pol_fast", "van_der_pol_mixed", "van_der_pol_slow"},
       20.0,
       table_2},
      {"table1-control", "example2", "Control of Table 1: the benefit of learning the eigenvalues", "vanderpol-rmse",
       "The paper compares learned eigenvalues with three fixed sets, but learning starts at none of these sets. Here "
       "each initial set is trained twice, with D frozen and with D learned; everything else is equal.",
       start_experiments(), 60.0, eigenvalue_starts},
      {"figure-vanderpol-compare",
       "example2",
       "Van der Pol with measurement noise",
       "vanderpol-compare",
       "With small eigenvalues, noise affects the observer little, but it takes about 10 s to converge. With large "
       "eigenvalues it converges quickly, but noise affects it severely. The learned observer does well in both.",
       {"van_der_pol_baseline_fast", "van_der_pol_baseline_slow", "van_der_pol_noise"},
       1.0,
       van_der_pol_with_noise},
      {"figure-vanderpol-compare-without",
       "example2",
       "Van der Pol without measurement noise",
       "vanderpol-compare-without",
       "The figure shows the three observers of the previous figure, without noise. The learned eigenvalues are -0.81, "
       "-0.83, -0.63.",
       {"van_der_pol_baseline_fast", "van_der_pol_baseline_slow", "van_der_pol_noise"},
       1.0,
       van_der_pol_without_noise},
      {"figure-vanderpol-compare-reg",
       "example2",
       "Van der Pol, regularised",
       "vanderpol-compare-reg",
       "The observer is trained with the eigenvalue penalty and tested with and without noise. Its eigenvalues are "
       "-0.66, -0.99, -1.77.",
       {"van_der_pol_regularised"},
       1.0,
       van_der_pol_regularised},
      {"figure-reg-traj",
       "example2",
       "Van der Pol, regularised, from (2, 0)",
       "reg-traj",
       "The regularised observer from x(0) = (2, 0).",
       {"van_der_pol_regularised"},
       1.0,
       van_der_pol_regularised_from_2_0},
      {"figure-vanderpol-compare-no",
       "example2",
       "Van der Pol, trained without robustness",
       "vanderpol-compare-no",
       "D is learned without noise and without regularisation. The observer is tested with and without noise.",
       {"van_der_pol_plain"},
       1.0,
       van_der_pol_without_robustness},
      {"figure-compare-x-rmse",
       "example3",
       "Reverse Duffing: error by initial state",
       "compare_x_rmse",
       "The observer trained on X1 fails outside of X1, because its training has no such data. There, the observer "
       "trained on X2 has a significantly smaller error.",
       {"reverse_duffing_x1", "reverse_duffing_x2"},
       40.0,
       duffing_map},
      {"figure-compare-x12",
       "example3",
       "Reverse Duffing from (2, 0)",
       "compare_x12",
       "x(0) = (2, 0) lies outside of X1 and inside of X2: the observer trained on X1 generalises extremely little.",
       {"reverse_duffing_x1", "reverse_duffing_x2"},
       1.0,
       duffing_from_2_0},
      {"figure-duff-exc",
       "example3",
       "Reverse Duffing with excitation",
       "duff-exc",
       "Excited by u = cos 12t, the observer with phi(z) u still performs satisfactorily.",
       {"reverse_duffing_driven"},
       12.0,
       duffing_driven},
      {"figure-osci-auto",
       "example3",
       "Reverse Duffing without excitation",
       "osci-auto",
       "The learned observer from x(0) = (-0.5, 0.5) without input.",
       {"reverse_duffing_x1"},
       1.0,
       duffing_unexcited},
      {"figure-compare-pde",
       "example3",
       "Reverse Duffing: the PDE as a constraint",
       "compare_pde",
       "Both observers are trained on X1. From x(0) = (3, 0) the RMSE is 0.98 without the PDE term and 0.86 with it. "
       "The improvement is not significant.",
       {"reverse_duffing_x1", "reverse_duffing_joint", "reverse_duffing_pde", "reverse_duffing_pde_x2"},
       1.0,
       duffing_pde},
      {"hyperkkl",
       "exams",
       "Driven observers: the benchmark of HyperKKL",
       "arXiv 2603.29744",
       "Each cell shows the smaller SMAPE of two methods with 125,000 multiply-adds, for four plants and four kinds of "
       "input. The paper lists Lorenz, too, but reports no SMAPE for it.",
       {"hyperkkl/duffing", "hyperkkl/van_der_pol", "hyperkkl/roessler", "hyperkkl/fitzhugh_nagumo", "hyperkkl/lorenz"},
       20.0,
       hyperkkl},
      {"inclination",
       "exams",
       "Inclination from an inertial sensor",
       "BROAD; RIANN, VQF",
       "On trial 24 and six other trials: VQF 0.91 deg, RIANN 1.38 deg with 365,000 multiply-adds.",
       {"inclination", kOneVector},
       5.0,
       inclination,
       "broad"},
      {"charge",
       "exams",
       "State of charge of a lithium-ion cell",
       "LG HG2; Wong et al., GoodIT 2021, table 3",
       "The paper reports errors on UDDS, LA92, US06 and one Mixed cycle after training on Mixed cycles. These test "
       "logs are not available here, so no published figure is shown beside ours.",
       {kCharge},
       5.0,
       charge,
       "battery"},
      {"silverbox",
       "exams",
       "Silverbox: an electronic circuit simulated from its input",
       "nonlinear benchmarks; arXiv 2405.10779",
       "On multisine / arrow / arrow without extrapolation: a linear model 6.96 / 14.4 / 6.58 mV, LSTM 1.50 / 2.68 / "
       ".960, GRU 1.49 / 2.80 / .947, Gaussian process NARX .301 / .60 / .259, the best of the table .36 / .26 / .32.",
       {"exams/silverbox"},
       5.0,
       silverbox,
       "silverbox"},
      {"lorenz",
       "exams",
       "Lorenz, all three states measured with noise",
       "KalmanNet, RTSNet (IEEE TSP)",
       "KalmanNet -11.1 dB, a smoother -16.8 dB, the EKF -6.3 dB with a Taylor step that is frozen over a sample.",
       {"exams/lorenz", "exams/lorenz_equations"},
       20.0,
       lorenz},
  };
  return kItems;
}

std::vector<const Item*> select_items(const std::string& what) {
  std::vector<const Item*> selected;
  for (const Item& item : items())
    if (what == "all" || what == item.example || what == item.name) selected.push_back(&item);
  if (!selected.empty()) return selected;
  std::vector<std::string> known{"all"};
  for (const Item& item : items()) {
    if (std::find(known.begin(), known.end(), item.example) == known.end()) known.emplace_back(item.example);
    if (item.name != item.example) known.emplace_back(item.name);
  }
  const std::string nearest = nearest_name(what, known);
  throw codegen::Error(fmt::format("{}: no item has this name; {}", what,
                                   nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                                   : fmt::format("did you mean \"{}\"?", nearest)));
}

}  // namespace nlo::trainer::reproduction
