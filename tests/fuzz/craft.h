// SPDX-License-Identifier: MIT
// An observer in C++ with the functions that flight.h calls. c99_craft.h has observers in C99.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "nlo/measurement.h"
#include "nlo/monitor.h"
#include "tests/fuzz/flight.h"

namespace nlo::hostile {

/// A C++ observer, with its monitor if there is a model of one.
template <class Observer, class MonitorModel = void>
class CppCraft {
 public:
  using Scalar = typename Observer::Scalar;
  static constexpr int kNy = Observer::kNy, kNu = Observer::kNu;
  static constexpr bool kWatched = !std::is_void_v<MonitorModel>;

  explicit CppCraft(const typename Observer::Model& model) : observer_(model) {}
  template <class Watching>
  CppCraft(const typename Observer::Model& model, const Watching& watching) : observer_(model), monitor_(watching) {
    double slowest = 1.0;
    for (const Scalar gain : watching.gain) slowest = std::fmin(slowest, static_cast<double>(gain));
    patience_ = watching.armed_after + std::lround(40.0 / slowest);
  }

  Scalar low(int j) const { return observer_.model().outputs.min[j]; }
  Scalar high(int j) const { return observer_.model().outputs.max[j]; }
  Scalar period_s() const { return observer_.model().sample_period_s; }

  /// Steps over `dt_s` if it is given.
  template <class... Dt>
  int step(const Scalar* y, const Scalar* u, Dt... dt_s) {
    return watched(y, [&](const Output& given) {
      if constexpr (Observer::kDriven)
        return observer_.step(given, input(u), dt_s...);
      else
        return observer_.step(given, dt_s...);
    });
  }
  int step_missed(const Scalar* u) {
    Scalar missing[kNy];
    for (Scalar& value : missing) value = std::numeric_limits<Scalar>::quiet_NaN();
    return watched(missing, [&](const Output&) {
      if constexpr (Observer::kDriven)
        return observer_.step_missed(input(u));
      else
        return observer_.step_missed();
    });
  }
  /// Takes a plain step if there is no steady state to start from.
  int warm_start(const Scalar* y, const Scalar* u) {
    if constexpr (!Observer::Model::kHasSteadyState)
      return step(y, u);
    else
      return watched(y, [&](const Output& given) {
        if constexpr (Observer::kReadsInputs)
          return observer_.warm_start(given, input(u));
        else
          return observer_.warm_start(given);
      });
  }
  void reset() { observer_.reset(); }
  /// Restores the saved state, with some of its bits flipped if `damage` is given. Returns false if it is refused.
  bool restore(Bits* damage) {
    auto state = observer_.save();
    if (damage != nullptr) damage->corrupt(&state, sizeof(state));
    const bool accepted = observer_.restore(state);
    if constexpr (kWatched) {
      auto statistics = monitor_.save();
      if (damage != nullptr) damage->corrupt(&statistics, sizeof(statistics));
      return monitor_.restore(statistics) && accepted;
    }
    return accepted;
  }
  /// Flips a bit in the memory after the pointers to the models.
  void flip(std::uint64_t bit) {
    constexpr std::size_t kPointer = sizeof(void*), kOwn = sizeof(Observer) - kPointer;
    constexpr std::size_t kAll = kOwn + (kWatched ? sizeof(Watch) - kPointer : 0);
    std::size_t byte = bit / 8 % kAll;
    auto* memory =
        byte < kOwn ? reinterpret_cast<unsigned char*>(&observer_) : reinterpret_cast<unsigned char*>(&monitor_) - kOwn;
    byte += kPointer;
    memory[byte] = static_cast<unsigned char>(memory[byte] ^ (1U << (bit % 8)));
  }

  int status() const { return static_cast<int>(observer_.status()); }
  bool latent_is_finite() const { return all_finite(observer_.latent()); }
  bool estimate_is_finite() const {
    (void)observer_.in_domain();
    if constexpr (requires { observer_.estimate_with_error(); }) {
      if (!all_finite(observer_.estimate_with_error().sigma)) return false;
    }
    return all_finite(observer_.estimate());
  }

  /// Returns what is wrong with the monitor; null if nothing is.
  const char* monitor_fault() const {
    if constexpr (kWatched) {
      const Alarm alarm = monitor_.alarm();
      if (alarm > Alarm::kReset) return "an alarm is one there is";
      if (!is_finite(monitor_.level())) return "a level is finite";
      const bool beyond = monitor_.level() > Scalar(1);
      if (monitor_.armed() && alarm != Alarm::kReset && (alarm != Alarm::kNone) != beyond)
        return "an alarm is what the level says";
      const bool early = alarm == Alarm::kNone || alarm == Alarm::kReset || (alarm == Alarm::kMissing && beyond);
      if (!monitor_.armed() && !early) return "only missing samples alarm before the monitor is armed";
    }
    return nullptr;
  }
  /// Samples after which a dead sensor must raise an alarm: until the monitor is armed, plus 40 time constants of its
  /// slowest average.
  long patience() const { return patience_; }
  bool alarms() const {
    if constexpr (kWatched) return monitor_.alarm() != Alarm::kNone;
    return true;
  }

 private:
  struct Nothing {};
  template <class M>
  struct WatchOf {
    using type = Monitor<M>;
  };
  using Watch = typename std::conditional_t<kWatched, WatchOf<MonitorModel>, std::type_identity<Nothing>>::type;
  using Output = typename Observer::Output;
  using Input = typename Observer::Input;

  template <class Values>
  static bool all_finite(const Values& values) {
    bool finite = true;
    for (const Scalar value : values) finite = finite && is_finite(value);
    return finite;
  }
  static Input input(const Scalar* u) {
    Input values{};
    for (int i = 0; i < kNu; ++i) values[i] = u[i];
    return values;
  }
  template <class Step>
  int watched(const Scalar* y, const Step& step) {
    Output given{};
    for (int j = 0; j < kNy; ++j) given[j] = y[j];
    if constexpr (kWatched) given = monitor_.usable_outputs(given, observer_);
    const auto status = static_cast<int>(step(given));
    if constexpr (kWatched) (void)monitor_.watch(observer_, observer_.estimate());
    return status;
  }

  Observer observer_;
  [[no_unique_address]] Watch monitor_;
  long patience_ = 0;
};

}  // namespace nlo::hostile

/// Declares the craft of an exported C++ header, with or without a monitor.
#define NLO_CPP_CRAFT(NAME)                                          \
  void fly_##NAME(nlo::hostile::Bits& bits, long steps) {            \
    using Craft = nlo::hostile::CppCraft<nlo::NAME::Observer>;       \
    nlo::hostile::fly(Craft(nlo::NAME::kModel), #NAME, bits, steps); \
  }
#define NLO_WATCHED_CRAFT(NAME)                                                           \
  void fly_##NAME(nlo::hostile::Bits& bits, long steps) {                                 \
    using Craft = nlo::hostile::CppCraft<nlo::NAME::Observer, nlo::NAME::MonitorModel>;   \
    nlo::hostile::fly(Craft(nlo::NAME::kModel, nlo::NAME::kMonitor), #NAME, bits, steps); \
  }
