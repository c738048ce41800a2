// SPDX-License-Identifier: MIT
// Why a flight is not what its replay answers: each cause that is known is tried by a replay with it, and the first
// that gives the logged bits is the one.
#pragma once

#include <Eigen/Core>
#include <string>

#include "trainer/replay/compare_flight.h"
#include "trainer/replay/flown_export.h"

namespace nlo::trainer {

/// What probably happened before `difference`, the first, in a sentence that ends in what to do. `answers`: of `flown`,
/// which is `arithmetic` of `model`.
std::string explain_flight(const FlightLog& log, const codegen::Model& model, const Flown& arithmetic,
                           const FlownExport& flown, const Eigen::MatrixXd& answers,
                           const FlightDifference& difference);

}  // namespace nlo::trainer
