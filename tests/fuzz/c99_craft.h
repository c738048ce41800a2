// SPDX-License-Identifier: MIT
// An observer in C99 with the functions that flight.h calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "nlo/measurement.h"
#include "nlo/monitor_model.h"
#include "tests/fuzz/flight.h"

namespace nlo::hostile {

/// A C99 observer, called through its functions, with its monitor if it has one: see NLO_C99_CRAFT.
template <class Calls, class Watch>
class C99Craft {
 public:
  using Scalar = typename Calls::Scalar;
  static constexpr int kNy = Calls::kNy, kNu = Calls::kNu;

  Scalar low(int) const { return Scalar(-4); }  // C99 has no function for the range
  Scalar high(int) const { return Scalar(4); }
  Scalar period_s() const { return Scalar(0.02); }

  C99Craft() {
    Calls::init(&observer);
    Watch::reset(&monitor);
  }

  int step(const Scalar* y, const Scalar* u) {
    return watched(y, [&](const Scalar* given) { return Calls::step(&observer, given, u); });
  }
  int step(const Scalar* y, const Scalar* u, Scalar dt_s) {
    return watched(y, [&](const Scalar* given) { return Calls::step_dt(&observer, given, u, dt_s); });
  }
  int step_missed(const Scalar* u) {
    Scalar missing[kNy];
    for (Scalar& value : missing) value = std::numeric_limits<Scalar>::quiet_NaN();
    return watched(missing, [&](const Scalar*) { return Calls::step_missed(&observer, u); });
  }
  int warm_start(const Scalar* y, const Scalar* u) {
    return watched(y, [&](const Scalar* given) { return Calls::warm_start(&observer, given, u); });
  }
  void reset() { Calls::reset(&observer); }
  bool restore(Bits* damage) {
    const auto restored = [&](auto& own, const auto& calls) {
      auto saved = own;
      if (damage != nullptr) damage->corrupt(&saved, sizeof(saved));
      return calls(&own, &saved);
    };
    const bool accepted = restored(observer, Calls::restore);
    return restored(monitor, Watch::restore) && accepted;
  }
  void flip(std::uint64_t bit) {
    const std::size_t byte = bit / 8 % (sizeof(observer) + sizeof(monitor));
    unsigned char& flipped = byte < sizeof(observer)
                                 ? reinterpret_cast<unsigned char*>(&observer)[byte]
                                 : reinterpret_cast<unsigned char*>(&monitor)[byte - sizeof(observer)];
    flipped = static_cast<unsigned char>(flipped ^ (1U << (bit % 8)));
  }
  int status() const {
    constexpr int kReset = static_cast<int>(StepStatus::kReset);
    int worst = Calls::status(&observer);
    for (int j = -1; j < kMostChannels; ++j) worst = Calls::status_of(&observer, j) > kReset ? kReset + 1 : worst;
    return worst;
  }
  bool latent_is_finite() const {
    bool finite = true;
    for (const Scalar z : observer.z) finite = finite && is_finite(z);
    return finite;
  }
  bool estimate_is_finite() const {
    Scalar x_hat[Calls::kNx];
    Calls::estimate(&observer, x_hat);
    bool finite = true;
    for (const Scalar x : x_hat) finite = finite && is_finite(x);
    for (int j = -1; j < kMostChannels; ++j) finite = finite && is_finite(Calls::staleness(&observer, j));
    (void)Calls::in_domain(&observer);
    return finite;
  }
  const char* monitor_fault() const {
    if (Watch::kWatched && !is_finite(level)) return "a level is finite";
    if (alarm > static_cast<int>(Alarm::kReset)) return "an alarm is one there is";
    return nullptr;
  }
  long patience() const { return kPatience; }
  bool alarms() const { return !Watch::kWatched || alarm != 0; }

  typename Calls::Observer observer;
  typename Watch::Monitor monitor;

 private:
  static constexpr int kMostChannels = 10;
  static constexpr long kPatience =
      Watch::kWatched ? 2000 : 0;  // 100 time constants of the slowest average of the examples

  template <class Step>
  int watched(const Scalar* y, const Step& step) {
    Scalar given[kNy], x_hat[Calls::kNx];
    for (int j = 0; j < kNy; ++j) given[j] = y[j];
    Watch::usable_outputs(&monitor, &observer, given);
    const int status = step(given);
    if (Watch::kWatched) Calls::estimate(&observer, x_hat);
    alarm = Watch::watch(&monitor, &observer, x_hat);
    level = Watch::template level<Scalar>(monitor);
    return status;
  }

  int alarm = 0;
  Scalar level = 0;
};

/// Calls for an observer without a monitor.
struct Unwatched {
  static constexpr bool kWatched = false;
  struct Monitor {};
  static constexpr auto restore = [](auto*, auto*) { return true; };
  static void reset(Monitor*) {}
  template <class... Any>
  static void usable_outputs(Any...) {}
  template <class... Any>
  static int watch(Any...) {
    return 0;
  }
  template <class Scalar>
  static Scalar level(const Monitor&) {
    return 0;
  }
};

}  // namespace nlo::hostile

/// Declares the craft of an exported C99 pair with NU inputs, with or without a monitor.
#define NLO_C99_CRAFT_OF(NAME, SCALAR, NU, WATCH)                                                   \
  struct NAME##_calls {                                                                             \
    using Scalar = SCALAR;                                                                          \
    using Observer = NAME##_observer;                                                               \
    static constexpr int kNx = NAME##_NX, kNy = NAME##_NY, kNu = NU;                                \
    static constexpr auto init = [](auto* o) { NAME##_init(o); };                                   \
    static constexpr auto reset = [](auto* o) { NAME##_reset(o); };                                 \
    static constexpr auto step = [](auto* o, auto* y, auto* u) -> int {                             \
      if constexpr (NU > 0)                                                                         \
        return NAME##_step(o, y, u);                                                                \
      else                                                                                          \
        return NAME##_step(o, y);                                                                   \
    };                                                                                              \
    static constexpr auto step_dt = [](auto* o, auto* y, auto* u, auto dt_s) -> int {               \
      if constexpr (NU > 0)                                                                         \
        return NAME##_step_dt(o, y, u, dt_s);                                                       \
      else                                                                                          \
        return NAME##_step_dt(o, y, dt_s);                                                          \
    };                                                                                              \
    static constexpr auto step_missed = [](auto* o, auto* u) -> int {                               \
      if constexpr (NU > 0)                                                                         \
        return NAME##_step_missed(o, u);                                                            \
      else                                                                                          \
        return NAME##_step_missed(o);                                                               \
    };                                                                                              \
    static constexpr auto warm_start = [](auto* o, auto* y, auto* u) -> int {                       \
      if constexpr (requires { NAME##_warm_start(o, y, u); })                                       \
        return NAME##_warm_start(o, y, u);                                                          \
      else if constexpr (requires { NAME##_warm_start(o, y); })                                     \
        return NAME##_warm_start(o, y);                                                             \
      else                                                                                          \
        return step(o, y, u);                                                                       \
    };                                                                                              \
    static constexpr auto estimate = [](auto* o, auto* x_hat) { NAME##_estimate(o, x_hat); };       \
    static constexpr auto status = [](auto* o) -> int { return NAME##_last_status(o); };            \
    static constexpr auto status_of = [](auto* o, int j) -> int { return NAME##_status_of(o, j); }; \
    static constexpr auto in_domain = [](auto* o) { return NAME##_in_domain(o); };                  \
    static constexpr auto staleness = [](auto* o, int output) -> Scalar {                           \
      if constexpr (requires { NAME##_staleness(o, output); })                                      \
        return NAME##_staleness(o, output);                                                         \
      else                                                                                          \
        return 0;                                                                                   \
    };                                                                                              \
    static constexpr auto restore = [](auto* o, auto* saved) { return NAME##_restore(o, saved); };  \
  };                                                                                                \
  void fly_##NAME(nlo::hostile::Bits& bits, long steps) {                                           \
    nlo::hostile::fly(nlo::hostile::C99Craft<NAME##_calls, WATCH>(), #NAME, bits, steps);           \
  }
#define NLO_C99_CRAFT(NAME, SCALAR, NU) NLO_C99_CRAFT_OF(NAME, SCALAR, NU, nlo::hostile::Unwatched)
#define NLO_C99_WATCHED_CRAFT(NAME, SCALAR, NU)                                                                        \
  struct NAME##_watch_calls {                                                                                          \
    static constexpr bool kWatched = true;                                                                             \
    using Monitor = NAME##_monitor;                                                                                    \
    static constexpr auto restore = [](auto* m, auto* saved) { return NAME##_monitor_restore(m, saved); };             \
    static void reset(Monitor* m) { NAME##_monitor_reset(m); }                                                         \
    static void usable_outputs(Monitor* m, const NAME##_observer* o, SCALAR* y) { NAME##_usable_outputs(m, o, y, y); } \
    static int watch(Monitor* m, const NAME##_observer* o, const SCALAR* x) { return NAME##_watch(m, o, x); }          \
    template <class Scalar>                                                                                            \
    static Scalar level(const Monitor& m) {                                                                            \
      return m.level;                                                                                                  \
    }                                                                                                                  \
  };                                                                                                                   \
  NLO_C99_CRAFT_OF(NAME, SCALAR, NU, NAME##_watch_calls)
