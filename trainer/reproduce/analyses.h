// SPDX-License-Identifier: MIT
// The analysis of each item; reproduced_items.cpp lists the items.
#pragma once

#include <string_view>

#include "trainer/reproduce/section.h"
#include "trainer/reproduce/workbench.h"

namespace nlo::trainer::reproduction {

// example1.cpp
Section luenberger_like(const Workbench& bench);

// tables.cpp
Section table_1(const Workbench& bench);
Section table_2(const Workbench& bench);

// eigenvalue_starts.cpp
std::vector<std::string_view> start_experiments();
Section eigenvalue_starts(const Workbench& bench);

// van_der_pol_figures.cpp
Section van_der_pol_with_noise(const Workbench& bench);
Section van_der_pol_without_noise(const Workbench& bench);
Section van_der_pol_regularised(const Workbench& bench);
Section van_der_pol_regularised_from_2_0(const Workbench& bench);
Section van_der_pol_without_robustness(const Workbench& bench);

// duffing.cpp
Section duffing_map(const Workbench& bench);
Section duffing_from_2_0(const Workbench& bench);
Section duffing_unexcited(const Workbench& bench);

// duffing_driven.cpp
Section duffing_driven(const Workbench& bench);

// duffing_pde.cpp
Section duffing_pde(const Workbench& bench);

// hyperkkl.cpp
Section hyperkkl(const Workbench& bench);

// log_exams.cpp
inline constexpr std::string_view kOneVector = "inclination observer.eigenvalues=[-0.3333333]",
                                  kCharge =
                                      "battery inverse_map.readout=\"network\" "
                                      "log.train_files=[\"0degC_Mixed[12456].csv\",\"10degC_Mixed[12456].csv\","
                                      "\"25degC_Mixed[12456].csv\"] "
                                      "log.test_files=[\"0degC_Mixed7.csv\",\"10degC_Mixed7.csv\","
                                      "\"25degC_Mixed7.csv\"]";
Section inclination(const Workbench& bench);
Section charge(const Workbench& bench);
Section silverbox(const Workbench& bench);

// lorenz.cpp
Section lorenz(const Workbench& bench);

}  // namespace nlo::trainer::reproduction
