// tiny: golden inputs and the expected results of its observer, generated. Do not edit. To make it again:
//   nlo export model.json --target replay -o tiny_replay.h
//
// The expected results are those of the model's equations in double, with nothing folded. A tolerance is
// 8 times the largest difference of the exported arithmetic (folded, in float, with the runtime's activation) on
// these samples, plus 8 rounding units of the largest value. Sums in another order stay within it; a wrong weight
// does not.
//
//   #include "tiny.h"
//   #include "tiny_replay.h"
//   nlo::tiny::Observer observer{nlo::tiny::kModel};
//   const int wrong = nlo::tiny::replay::first_mismatch(observer);  // -1: all results are right
#pragma once

#include <nlo/vector.h>

#include <limits>

namespace nlo::tiny::replay {

struct Sample {
  float dt_s;  // 0: one sample period
  float y[1];
  StepStatus status;
  float z[2];
  float x_hat[1];
};

inline constexpr float kMissed = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kLatentTolerance[2] = {};
inline constexpr float kEstimateTolerance[1] = {};

inline constexpr Sample kSamples[] = {
    {0.0f, {-1.0536094f}, StepStatus::kOk, {0.0f, 0.0f}, {0.52013534f}},
    {0.0f, {-1.0184203f}, StepStatus::kOk, {-0.020513307f, -0.019908642f}, {0.57344264f}},
    {0.0f, {-0.8917916f}, StepStatus::kOk, {-0.039015304f, -0.036719777f}, {0.61920846f}},
    {0.0f, {-0.68404925f}, StepStatus::kOk, {-0.05383776f, -0.04901456f}, {0.6538805f}},
    {0.0f, {-0.41386133f}, StepStatus::kOk, {-0.06363283f, -0.055762947f}, {0.6748891f}},
    {0.0f, {-0.106026106f}, StepStatus::kOk, {-0.06750988f, -0.0564326f}, {0.6807295f}},
    {0.0f, {0.21137758f}, StepStatus::kOk, {-0.06511958f, -0.051040713f}, {0.67098325f}},
    {0.0f, {0.5101067f}, StepStatus::kOk, {-0.056677092f, -0.040144447f}, {0.6463326f}},
    {0.0f, {0.7647473f}, StepStatus::kOk, {-0.042924505f, -0.024773441f}, {0.60857815f}},
    {0.0f, {0.955228f}, StepStatus::kOk, {-0.02503936f, -0.0063146153f}, {0.5606193f}},
    {0.0f, {1.0685729f}, StepStatus::kOk, {-0.004502836f, 0.013635048f}, {0.50631875f}},
    {0.0f, {1.0997293f}, StepStatus::kOk, {0.017054984f, 0.0334291f}, {0.45017722f}},
    {0.0f, {6.0f}, StepStatus::kClamped, {0.057370026f, 0.0705027f}, {0.3437259f}},
    {0.0f, {0.93317205f}, StepStatus::kOk, {0.095106825f, 0.10261696f}, {0.24780947f}},
    {0.0f, {0.75953525f}, StepStatus::kOk, {0.109976776f, 0.11097283f}, {0.21724379f}},
    {0.0f, {0.54807323f}, StepStatus::kOk, {0.120738305f, 0.11498046f}, {0.19860233f}},
    {0.0f, {0.3171291f}, StepStatus::kOk, {0.12690598f, 0.11442574f}, {0.19261998f}},
    {0.0f, {0.083848946f}, StepStatus::kOk, {0.12835532f, 0.109451964f}, {0.19907793f}},
    {0.0f, {-0.13735044f}, StepStatus::kOk, {0.12527671f, 0.10049438f}, {0.2169914f}},
    {0.0f, {-0.3356999f}, StepStatus::kOk, {0.118106015f, 0.08819636f}, {0.24479635f}},
    {0.02612997f, {-0.5494578f}, StepStatus::kOk, {0.10363309f, 0.06841657f}, {0.29262248f}},
    {0.031865016f, {-0.7329285f}, StepStatus::kHeld, {0.080258064f, 0.04098765f}, {0.36212134f}},
    {0.03907209f, {-0.8440625f}, StepStatus::kHeld, {0.046954762f, 0.006483559f}, {0.4526747f}},
    {0.022219496f, {-0.8539664f}, StepStatus::kOk, {0.027265918f, -0.012120021f}, {0.50274444f}},
    {0.02221647f, {-0.8251006f}, StepStatus::kOk, {0.008222206f, -0.028931636f}, {0.5489609f}},
    {0.032412622f, {-0.70885473f}, StepStatus::kHeld, {-0.0164912f, -0.048691113f}, {0.60547686f}},
    {0.036075156f, {-0.46688455f}, StepStatus::kHeld, {-0.036710624f, -0.061799034f}, {0.64742225f}},
    {0.02473815f, {-0.23189957f}, StepStatus::kOk, {-0.044339057f, -0.06416048f}, {0.66009f}},
    {0.0f, {-0.0066553904f}, StepStatus::kOk, {-0.0458155f, -0.06149135f}, {0.65880275f}},
    {0.0f, {0.24046768f}, StepStatus::kOk, {-0.042585243f, -0.054484967f}, {0.64613026f}},
    {0.0f, {0.49590692f}, StepStatus::kOk, {-0.034442972f, -0.04318634f}, {0.6215895f}},
    {0.0f, {0.74229556f}, StepStatus::kOk, {-0.021493796f, -0.027934756f}, {0.5853551f}},
    {0.0f, {kMissed}, StepStatus::kHeld, {-0.006369754f, -0.01151943f}, {0.5441357f}},
    {0.0f, {kMissed}, StepStatus::kHeld, {0.008454812f, 0.003633824f}, {0.5044069f}},
    {0.0f, {kMissed}, StepStatus::kHeld, {0.022985833f, 0.01762204f}, {0.46624053f}},
    {0.0f, {kMissed}, StepStatus::kHeld, {0.03722912f, 0.030534793f}, {0.42968053f}},
    {0.0f, {kMissed}, StepStatus::kHeld, {0.05119037f, 0.042454764f}, {0.39474577f}},
    {0.0f, {0.9978181f}, StepStatus::kOk, {0.06741345f, 0.055946715f}, {0.35455602f}},
    {0.0f, {0.74379945f}, StepStatus::kOk, {0.08331335f, 0.068350516f}, {0.31638825f}},
    {0.0f, {0.42159358f}, StepStatus::kOk, {0.09319117f, 0.074254155f}, {0.29554448f}},
};

/// Steps `observer`, new or reset, through the samples. Returns the index of the first wrong result, or -1.
template <class Observer>
int first_mismatch(Observer& observer) {
  const auto agrees = [](float got, float want, float tolerance) {
    return got - want <= tolerance && want - got <= tolerance;  // false for NaN
  };
  int index = 0;
  for (const Sample& sample : kSamples) {
    typename Observer::Output y{};
    for (int j = 0; j < 1; ++j) y[j] = sample.y[j];
    const StepStatus status = sample.dt_s > float(0) ? observer.step(y, sample.dt_s) : observer.step(y);
    const auto z = observer.latent();
    const auto x_hat = observer.estimate();
    bool good = status == sample.status;
    for (int r = 0; r < 2; ++r) good = good && agrees(z[r], sample.z[r], kLatentTolerance[r]);
    for (int i = 0; i < 1; ++i) good = good && agrees(x_hat[i], sample.x_hat[i], kEstimateTolerance[i]);
    if (!good) return index;
    ++index;
  }
  return -1;
}

}  // namespace nlo::tiny::replay
