// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/estimator_words.h"

namespace nlo::trainer {

namespace {

constexpr EstimatorWords kWords[] = {
    {"ekf", "EKF", "extended Kalman filter"},
    {"ekf_true", "EKF that knows the changed plant", "extended Kalman filter"},
    {"ukf", "UKF", "unscented Kalman filter"},
    {"ekf_bank", "EKF bank", "eight EKFs with different initial states, weighted by their innovations"},
    {"joint_ekf", "joint EKF", "EKF that also estimates the parameters that conditions change"},
    {"mhe", "moving horizon", "moving horizon, one Gauss-Newton step per sample"},
    {"high_gain", "high gain", "high-gain observer"},
    {"particle", "particle filter", "particle filter that knows each condition"},
    {"static_ridge", "static ridge", "ridge regression on the last three samples and their products", false},
    {"constant", "constant", "always the mean state", false},
    {"ridge", "ridge", "a linear map of the inputs of the observer's network", false},
};

}  // namespace

std::vector<std::string> simple_names() {
  std::vector<std::string> names;
  for (const EstimatorWords& words : kWords)
    if (!words.knows_plant) names.emplace_back(words.name);
  return names;
}

const EstimatorWords* estimator_words(std::string_view name) {
  for (const EstimatorWords& words : kWords)
    if (words.name == name) return &words;
  return nullptr;
}

}  // namespace nlo::trainer
