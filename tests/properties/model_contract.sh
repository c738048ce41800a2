#!/bin/sh
# SPDX-License-Identifier: MIT
# A model that lacks a member does not compile, and the first error of the compiler names the missing member.
#   usage: model_contract.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 work=$4
mkdir -p "$work"
cat >"$work/whole.cpp" <<'CPP'
#include <nlo/sampled_observer.h>
struct Model {
  using Scalar = float;
  static constexpr int kNx = 1;
  static constexpr int kNy = 1;
  static constexpr int kNz = 2;
  static constexpr int kNu = 0;
  static constexpr int kNf = 0;
  static constexpr int kNr = 1;
  static constexpr int kLongestGap = 10;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = false;
  float sample_period_s;
  unsigned short stale_after;
  nlo::OutputRange<float, 1> outputs;
  nlo::Domain<float, 2> domain;
  float initial[2];
  constexpr const float (&initial_latent() const)[2] { return initial; }
  void advance(float (&)[2], const float (&)[1], const float (&)[1], float) const {}
  void estimate(const float (&)[2], const float (&)[1], float (&x_hat)[1]) const { x_hat[0] = 0; }
};
int main() {
  static constexpr Model kModel{};
  nlo::SampledObserver<Model> observer(kModel);
  return observer.step(1.0F) == nlo::StepStatus::kOk ? 0 : 1;
}
CPP
compile() { "$compiler" -std=c++20 -fsyntax-only -I"$source/runtime/include" "$work/$1.cpp" >"$work/$1.txt" 2>&1; }
compile whole || { cat "$work/whole.txt"; exit 1; }

failed=0
for member in Scalar kNx kNy kNz kNu kNf kNr kLongestGap kHasSteadyState kMayDiverge sample_period_s stale_after outputs \
  domain initial_latent advance estimate; do
  grep -vE "^  (using|static constexpr|float|unsigned|nlo::|constexpr|void)[^;{]*[ (&]$member[ ;(]" "$work/whole.cpp" >"$work/lacks.cpp"
  [ "$(wc -l <"$work/lacks.cpp")" -eq $(($(wc -l <"$work/whole.cpp") - 1)) ] || { echo "FAILED   not on a separate line: $member"; failed=1; }
  if compile lacks; then
    echo "FAILED   compiles without $member" && failed=1
  elif ! grep -q 'ObserverModel' "$work/lacks.txt" || ! grep -qi "$member" "$work/lacks.txt"; then
    head -20 "$work/lacks.txt" && echo "FAILED   the message does not name $member" && failed=1
  fi
done
exit "$failed"
