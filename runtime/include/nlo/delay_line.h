// SPDX-License-Identifier: MIT
// Delay of inputs. If a command reaches the plant d samples late, the observer must get the delayed command:
//   u_acting[k] = (1 - c) u[k - n] + c u[k - n - 1]      d = n + c samples, n an integer, 0 <= c < 1
// For a command that is held over each sample period this is the mean of the delayed command over the period.
//
//   constinit nlo::DelayLine<1, 4> line({2.4F});          // one input, 2.4 samples late; room for 4
//   observer.step(y, line.push({{u}}));                   // u: the command of this sample
#pragma once

#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// Stores the last kSamples inputs; allocates nothing. A delay outside of 0 .. kSamples is a compile error if the line
/// is constinit, as above. A delay computed at run time is limited to that range.
///   kChannels  number of inputs
///   kSamples   longest delay [samples]
template <int kChannels, int kSamples, class Scalar = float>
class DelayLine {
  static_assert(kChannels > 0 && kSamples > 0);

 public:
  /// delay: delay of each input [samples]; NaN counts as 0. The constructor is not consteval because clang 14 loses the
  /// members that a consteval constructor sets.
  constexpr explicit DelayLine(const Scalar (&delay)[kChannels]) {
    for (int i = 0; i < kChannels; ++i) {
      if (!(delay[i] >= Scalar(0) && delay[i] <= Scalar(kSamples))) delay_is_outside_of_the_line();
      const Scalar past = delay[i] > Scalar(0) ? delay[i] : Scalar(0);
      const Scalar within = past < Scalar(kSamples) ? past : Scalar(kSamples);
      whole_[i] = static_cast<int>(within);
      part_[i] = within - static_cast<Scalar>(whole_[i]);
    }
  }

  /// Stores the inputs of this sample and returns the inputs that act now. Inputs before the first call count as equal
  /// to the first ones. An input that is not finite is returned unchanged when its time comes; the observer then holds
  /// the last good one.
  constexpr Vector<Scalar, kChannels> push(const Vector<Scalar, kChannels>& u) {
    if (!started_)
      for (auto& slot : past_) slot = u;
    started_ = true;
    newest_ = newest_ == kSlots - 1 ? 0 : newest_ + 1;
    past_[newest_] = u;
    Vector<Scalar, kChannels> acting{};
    for (int i = 0; i < kChannels; ++i) {
      const Scalar late = at(whole_[i])[i];
      // A value with weight 0 is not read, because 0 times a value that is not finite is not 0.
      acting[i] = part_[i] > Scalar(0) ? late + part_[i] * (at(whole_[i] + 1)[i] - late) : late;
    }
    return acting;
  }

  /// Forgets all inputs. The next ones count as those of all earlier samples.
  constexpr void reset() { started_ = false; }

 private:
  static constexpr int kSlots = kSamples + 1;

  static void delay_is_outside_of_the_line() {}  // not constexpr, so that calling it in a constant is a compile error

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

}  // namespace nlo::inline NLO_ISA
