// SPDX-License-Identifier: MIT
// An exported int16 observer on a core, compared with the golden samples of its model, which come from the equations in
// double.
#include <van_der_pol.h>  // generated, both
#include <van_der_pol_replay.h>

#include "tests/embedded/target/text.h"

namespace nlo::target {
namespace {

using van_der_pol::kModel;
using van_der_pol::Model;

template <class Observer>
bool replays(const char* name, Observer observer) {
  const int mismatch = van_der_pol::replay::first_mismatch(observer);
  board::write(name);
  if (mismatch == -1) {
    board::write("all results are right\n");
    return true;
  }
  board::write("wrong at sample ");
  board::write(static_cast<std::uint32_t>(mismatch));
  board::write("\n");
  return false;
}

/// Control: one weight of the last layer changed by a sixteenth of the largest weight must be detected.
bool altered_model_is_detected() {
  static constexpr Model kAltered = [] {
    Model model = kModel;
    model.inverse_map.mlp.tail.tail.layer.weights[0] += 700;
    return model;
  }();
  van_der_pol::Observer observer{kAltered};
  const bool seen = van_der_pol::replay::first_mismatch(observer) != -1;
  board::write(seen ? "control: seen\n" : "control: a wrong weight went unseen\n");
  return seen;
}

}  // namespace

bool run_all() {
  const bool fast = replays("fast: ", van_der_pol::Observer{kModel});
  const bool deterministic = replays("deterministic: ", KklObserver<Model, Arithmetic::kDeterministic>{kModel});
  return altered_model_is_detected() && fast && deterministic;
}

}  // namespace nlo::target

int main() {
  return nlo::target::run_all() ? 0 : 1;
}
