// SPDX-License-Identifier: MIT
// The error head of a trained T* (codegen/model/error_head_parameters.h), which T* does not notice.
#pragma once

#include "codegen/model/error_head_parameters.h"
#include "trainer/learn/uncertainty/error_samples.h"

namespace nlo::trainer {

/// W and b of the largest likelihood (deviation_likelihood.h) on `training`, by the ridge whose head is the likeliest
/// on `validation`; the range of log sigma over `training`, no larger than the largest error there; the factors of a
/// normal distribution, 1 and 1.96. Samples outside of the domain do not count: there sigma is the largest.
codegen::ErrorHead fit_error_head(const ErrorSamples& training, const ErrorSamples& validation);

}  // namespace nlo::trainer
