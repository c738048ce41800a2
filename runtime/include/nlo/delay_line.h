// SPDX-License-Identifier: MIT
// An input that reaches the plant late, on its way to an observer: what acts now was commanded some samples ago,
//   u_acting[k] = (1 - c) u[k - n] + c u[k - n - 1]      delay d = n + c samples, n whole, 0 <= c < 1
// Of a command that is held over each period and comes late by c of one, this is its mean over the period.
//
//   constinit nlo::DelayLine<1, 4> line({2.4F});          // one input, 2.4 samples late; room for 4
//   observer.step(y, line.push({{u}}));                   // u: the command of this sample
#pragma once

#include "nlo/vector.h"

namespace nlo {

/// Remembers the last kSamples inputs; allocates nothing. A delay outside of 0 .. kSamples does not compile where the
/// line is a constant (constinit, as above); one of run time is held within.
///   kChannels  how many inputs
///   kSamples   the longest delay there is room for [samples]
template <int kChannels, int kSamples, class Scalar = float>
class DelayLine {
  static_assert(kChannels > 0 && kSamples > 0);

 public:
  /// The delay of each input [samples]; not a number: 0. (Not consteval:
  /// clang 14 forgets what such a constructor sets.)
  constexpr explicit DelayLine(const Scalar (&delay)[kChannels]) {
    for (int i = 0; i < kChannels; ++i) {
      if (!(delay[i] >= Scalar(0) && delay[i] <= Scalar(kSamples))) delay_is_outside_of_the_line();
      const Scalar past = delay[i] > Scalar(0) ? delay[i] : Scalar(0);
      const Scalar within = past < Scalar(kSamples) ? past : Scalar(kSamples);
      whole_[i] = static_cast<int>(within);
      part_[i] = within - static_cast<Scalar>(whole_[i]);
    }
  }

  /// Takes the inputs of this sample and gives those that act now. Before the line is full the first ones stand for
  /// what came before. An input that is not finite comes out as it is, when it acts:
  /// the observer holds the last one then.
  constexpr Vector<Scalar, kChannels> push(const Vector<Scalar, kChannels>& u) {
    if (!started_)
      for (auto& slot : past_) slot = u;
    started_ = true;
    newest_ = newest_ == kSlots - 1 ? 0 : newest_ + 1;
    past_[newest_] = u;
    Vector<Scalar, kChannels> acting{};
    for (int i = 0; i < kChannels; ++i) {
      const Scalar late = at(whole_[i])[i];
      // What has no share in the result is not read: 0 times a value that is not finite is not 0.
      acting[i] = part_[i] > Scalar(0) ? late + part_[i] * (at(whole_[i] + 1)[i] - late) : late;
    }
    return acting;
  }

  /// Forgets all inputs: the next one stands for what came before it.
  constexpr void reset() { started_ = false; }

 private:
  static constexpr int kSlots = kSamples + 1;

  static void delay_is_outside_of_the_line() {}  // not constexpr: a delay that gets here is an error of compilation

  constexpr const Vector<Scalar, kChannels>& at(int samples_ago) const {
    const int slot = newest_ - samples_ago;
    return past_[slot < 0 ? slot + kSlots : slot];
  }

  Vector<Scalar, kChannels> past_[kSlots] = {};
  int whole_[kChannels] = {};
  Scalar part_[kChannels] = {};
  int newest_ = 0;
  bool started_ = false;
};

}  // namespace nlo
