// SPDX-License-Identifier: MIT
// Fits the error head of a trained T* (codegen/model/error_head_parameters.h). T* itself does not change.
#pragma once

#include "codegen/model/error_head_parameters.h"
#include "trainer/learn/uncertainty/error_samples.h"

namespace nlo::trainer {

/// Fits W and b by the largest likelihood (deviation_likelihood.h) on `training`. Uses the ridge with the largest
/// likelihood on `validation`. The range of log sigma is its range over `training`, at most the largest error there.
/// The factors are those of a normal distribution, 1 and 1.96. Samples outside of the domain do not count, because
/// there sigma is set to its largest value.
codegen::ErrorHead fit_error_head(const ErrorSamples& training, const ErrorSamples& validation);

}  // namespace nlo::trainer
