// SPDX-License-Identifier: MIT
// Flights through anything: measurements, inputs and time steps of any bits, states from storage that are damaged, bits
// of memory that flip, in an observer and in the monitor beside it. After each step:
//   - the status is one there is, and the observer's own
//   - z is finite, and what save() gives restore() takes
//   - an estimate with a good status is finite
//   - a monitor's level is finite, and its alarm is what its level says
// Now and then the sensor is dead for long: the observer has to say kStale and the monitor has to alarm, whatever came
// before. Each observer, C++ or C99, flies behind the same calls, as a craft.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>

#include "nlo/measurement.h"
#include "nlo/monitor.h"

namespace nlo::hostile {

/// Where a flight takes its bits from: a generator (xorshift64*, Vigna 2016), or the bytes of a fuzzer.
class Bits {
 public:
  explicit Bits(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL + 1) {}
  Bits(const std::uint8_t* bytes, std::size_t size) : at_(bytes), end_(bytes + size) {}

  bool ended() const { return end_ != nullptr && at_ == end_; }

  /// So many bits, 8 to 64, in whole bytes; zeros after the last.
  std::uint64_t operator()(int bits) {
    if (end_ == nullptr) {
      state_ ^= state_ >> 12;
      state_ ^= state_ << 25;
      state_ ^= state_ >> 27;
      return (state_ * 0x2545f4914f6cdd1dULL) >> (64 - bits);
    }
    std::uint64_t value = 0;
    for (int i = 0; i < bits; i += 8)
      if (at_ < end_) value |= std::uint64_t{*at_++} << i;
    return value;
  }

  /// Flips a few of the bits there, as storage does.
  void spoil(void* memory, std::size_t bytes) {
    auto* to = static_cast<unsigned char*>(memory);
    for (auto flips = (*this)(8) % 4; flips > 0; --flips) {
      const auto bit = (*this)(16);
      unsigned char& byte = to[bit / 8 % bytes];
      byte = static_cast<unsigned char>(byte ^ (1U << (bit % 8)));
    }
  }

 private:
  std::uint64_t state_ = 0;
  const std::uint8_t *at_ = nullptr, *end_ = nullptr;
};

/// A number for a sensor whose range is [low, high]: mostly one of those, sometimes beyond, sometimes any bits.
template <class Scalar>
Scalar reading(Bits& bits, Scalar low, Scalar high) {
  using Limits = std::numeric_limits<Scalar>;
  constexpr Scalar kSpecial[] = {
      Scalar(0),          -Scalar(0),          Limits::denorm_min(), -Limits::min(),  Limits::max(), Limits::lowest(),
      Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),  Scalar(0x1p100), Scalar(1),     Scalar(-1e30)};
  const auto kind = bits(8);
  if (kind < 24) {
    const std::uint64_t any = bits(8 * sizeof(Scalar));
    Scalar value;
    std::memcpy(&value, &any, sizeof(value));  // the lower bytes, on this machine
    return value;
  }
  if (kind < 36) return kSpecial[kind - 24];
  if (kind < 40) return kind % 2 == 0 ? low : high;
  const auto share = static_cast<Scalar>(bits(16)) / Scalar(65535);
  return (low * (Scalar(1) - share) + high * share) * (kind < 56 ? Scalar(2) : Scalar(1));
}

/// A C++ observer, with its monitor where there is a model of one.
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

  /// Over `dt_s` where it is given.
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
  /// A step where there is no steady state to start from.
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
  /// From what is saved, with some of its bits flipped where `damage` is given. False: refused.
  bool restore(Bits* damage) {
    auto state = observer_.save();
    if (damage != nullptr) damage->spoil(&state, sizeof(state));
    const bool taken = observer_.restore(state);
    if constexpr (kWatched) {
      auto statistics = monitor_.save();
      if (damage != nullptr) damage->spoil(&statistics, sizeof(statistics));
      return monitor_.restore(statistics) && taken;
    }
    return taken;
  }
  /// A bit of what follows the pointers to the models.
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

  /// What the monitor has wrong; null: nothing.
  const char* monitor_fault() const {
    if constexpr (kWatched) {
      const Alarm alarm = monitor_.alarm();
      if (alarm > Alarm::kReset) return "an alarm is one there is";
      if (!is_finite(monitor_.level())) return "a level is finite";
      const bool beyond = monitor_.armed() && monitor_.level() > Scalar(1);
      if (alarm != Alarm::kReset && (alarm != Alarm::kNone) != beyond) return "an alarm is what the level says";
    }
    return nullptr;
  }
  /// Samples after which a dead sensor is an alarm: until it is armed, and 40 time constants of its slowest average.
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
    if constexpr (kWatched) given = monitor_.trusted(given, observer_);
    const auto status = static_cast<int>(step(given));
    if constexpr (kWatched) (void)monitor_.watch(observer_, observer_.estimate());
    return status;
  }

  Observer observer_;
  [[no_unique_address]] Watch monitor_;
  long patience_ = 0;
};

/// A C99 observer by its calls: see NLO_C99_CRAFT.
template <class Calls>
class C99Craft {
 public:
  using Scalar = typename Calls::Scalar;
  static constexpr int kNy = Calls::kNy, kNu = Calls::kNu;

  Scalar low(int) const { return Scalar(-4); }  // no call tells the range
  Scalar high(int) const { return Scalar(4); }
  Scalar period_s() const { return Scalar(0.02); }

  int step(const Scalar* y, const Scalar* u) { return Calls::step(&observer, y, u); }
  int step(const Scalar* y, const Scalar* u, Scalar dt_s) { return Calls::step_dt(&observer, y, u, dt_s); }
  int step_missed(const Scalar* u) { return Calls::step_missed(&observer, u); }
  int warm_start(const Scalar* y, const Scalar* u) { return Calls::warm_start(&observer, y, u); }
  void reset() { Calls::reset(&observer); }
  bool restore(Bits* damage) {
    typename Calls::Observer saved = observer;
    if (damage != nullptr) damage->spoil(&saved, sizeof(saved));
    return Calls::restore(&observer, &saved);
  }
  void flip(std::uint64_t bit) {
    auto& byte = reinterpret_cast<unsigned char*>(&observer)[bit / 8 % sizeof(observer)];
    byte = static_cast<unsigned char>(byte ^ (1U << (bit % 8)));
  }
  int status() const { return Calls::status(&observer); }
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
    for (int j = 0; j < kNy; ++j) finite = finite && is_finite(Calls::staleness(&observer, j));
    (void)Calls::in_domain(&observer);
    return finite;
  }
  const char* monitor_fault() const { return nullptr; }  // C99 has none
  long patience() const { return 0; }
  bool alarms() const { return true; }

  typename Calls::Observer observer;
};

/// Ends the program with which craft failed in what.
[[noreturn]] inline void crash(const char* craft, const char* what) {
  std::fprintf(stderr, "%s: not so: %s\n", craft, what);
  std::abort();
}

/// So many steps, or until the bits end.
template <class Craft>
void fly(Craft craft, const char* name, Bits& bits, long steps) {
  using Scalar = typename Craft::Scalar;
  constexpr int kMostInputs = 8;
  constexpr long kDeadEvery = 20'000, kMostHeld = 70'000;          // stale_after is below 2^16
  constexpr int kHeld = 2, kStale = 3, kDiverged = 5, kReset = 6;  // of StepStatus
  static_assert(Craft::kNu <= kMostInputs);
  Scalar y[Craft::kNy], u[kMostInputs] = {};
  // An angle that was flipped to thousands of turns comes back into its first in as many steps as it has digits; what a
  // monitor's averages were given they forget in its patience.
  constexpr int kHealing = 4;
  int healing = 0;     // steps, with measurements that are used as they come, until a flip is gone from the observer
  long forgotten = 0;  // sample by which it is gone from the monitor
  const auto check = [&](bool holds, const char* what) {
    if (!holds) crash(name, what);
  };
  const auto check_step = [&](int status) {
    check(status >= 0 && status <= kReset, "a status is one there is");
    const int said = craft.status();  // kReset, too, where a step was rejected and a bit has flipped
    check(said == status || said == kReset, "the observer says what its step said");
    check(said == kReset || craft.latent_is_finite(), "z is finite");
    check(said > kHeld || craft.estimate_is_finite(), "an estimate with a good status is finite");
    const char* fault = craft.monitor_fault();
    if (fault != nullptr) crash(name, fault);
  };
  const auto fly_with_a_dead_sensor = [&](long samples) {
    for (Scalar& input : u) input = 0;
    for (int j = 0; j < Craft::kNy; ++j) y[j] = craft.low(j) / 2 + craft.high(j) / 2;
    // A flip may have left z at 2^100: until it has decayed, a monitor keeps kMostRejected in a row away.
    int status = kHeld;
    for (long k = 0; k < kMostHeld && status >= kHeld && status != kDiverged; ++k)
      check_step(status = craft.step(y, u));
    check(status < kHeld || status == kDiverged, "good measurements are taken, whatever came before");
    long missed = 0;
    while (status != kStale && missed++ < kMostHeld) check_step(status = craft.step_missed(u));
    check(status == kStale, "a dead sensor makes the observer stale");
    for (; missed < samples; ++missed) check_step(craft.step_missed(u));
    check(craft.alarms(), "a dead sensor is an alarm");
  };
  for (long k = 0; k < steps && !bits.ended(); ++k) {
    for (int j = 0; j < Craft::kNy; ++j) y[j] = reading(bits, craft.low(j), craft.high(j));
    for (int i = 0; i < Craft::kNu; ++i) u[i] = reading(bits, Scalar(-1), Scalar(1));
    const auto event = bits(8), way = bits(8);
    if (event < 2) craft.reset();
    if (event >= 2 && event < 8) (void)craft.restore(&bits);
    if (event >= 8 && event < 16)
      check(craft.restore(nullptr) || healing > 0 || k < forgotten, "what is saved can be restored");
    if (event >= 16 && event < 32) {
      craft.flip(bits(24));
      healing = kHealing;
      forgotten = k + craft.patience();
    }
    int status;
    if (way < 32) {
      status = craft.step(y, u, reading(bits, Scalar(0), Scalar(3) * craft.period_s()));
    } else if (way < 36) {
      status = craft.step(y, u, reading(bits, Scalar(0), Scalar(1001) * craft.period_s()));
    } else if (way < 52) {
      status = craft.step_missed(u);
    } else if (way < 56) {
      status = craft.warm_start(y, u);
    } else {
      status = craft.step(y, u);
    }
    if (status == 0 && healing > 0) --healing;
    check_step(status);
    // Once for so long that what counts in 16 bits is full.
    if (k % kDeadEvery == kDeadEvery - 1) fly_with_a_dead_sensor(k < kDeadEvery ? kMostHeld : craft.patience());
  }
}

/// All that were compiled into the program.
struct NamedCraft {
  const char* name;
  void (*fly)(Bits& bits, long steps);
};
extern const NamedCraft kFleet[];
extern const int kFleetSize;

}  // namespace nlo::hostile

/// The craft of an exported C++ header, with its monitor or without, and of an exported pair of C99 with NU inputs.
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
#define NLO_C99_CRAFT(NAME, SCALAR, NU)                                                            \
  struct NAME##_calls {                                                                            \
    using Scalar = SCALAR;                                                                         \
    using Observer = NAME##_observer;                                                              \
    static constexpr int kNx = NAME##_NX, kNy = NAME##_NY, kNu = NU;                               \
    static constexpr auto reset = [](auto* o) { NAME##_reset(o); };                                \
    static constexpr auto step = [](auto* o, auto* y, auto* u) -> int {                            \
      if constexpr (NU > 0)                                                                        \
        return NAME##_step(o, y, u);                                                               \
      else                                                                                         \
        return NAME##_step(o, y);                                                                  \
    };                                                                                             \
    static constexpr auto step_dt = [](auto* o, auto* y, auto* u, auto dt_s) -> int {              \
      if constexpr (NU > 0)                                                                        \
        return NAME##_step_dt(o, y, u, dt_s);                                                      \
      else                                                                                         \
        return NAME##_step_dt(o, y, dt_s);                                                         \
    };                                                                                             \
    static constexpr auto step_missed = [](auto* o, auto* u) -> int {                              \
      if constexpr (NU > 0)                                                                        \
        return NAME##_step_missed(o, u);                                                           \
      else                                                                                         \
        return NAME##_step_missed(o);                                                              \
    };                                                                                             \
    static constexpr auto warm_start = [](auto* o, auto* y, auto* u) -> int {                      \
      if constexpr (requires { NAME##_warm_start(o, y, u); })                                      \
        return NAME##_warm_start(o, y, u);                                                         \
      else if constexpr (requires { NAME##_warm_start(o, y); })                                    \
        return NAME##_warm_start(o, y);                                                            \
      else                                                                                         \
        return step(o, y, u);                                                                      \
    };                                                                                             \
    static constexpr auto estimate = [](auto* o, auto* x_hat) { NAME##_estimate(o, x_hat); };      \
    static constexpr auto status = [](auto* o) -> int { return NAME##_last_status(o); };           \
    static constexpr auto in_domain = [](auto* o) { return NAME##_in_domain(o); };                 \
    static constexpr auto staleness = [](auto* o, int output) -> Scalar {                          \
      if constexpr (requires { NAME##_staleness(o, output); })                                     \
        return NAME##_staleness(o, output);                                                        \
      else                                                                                         \
        return 0;                                                                                  \
    };                                                                                             \
    static constexpr auto restore = [](auto* o, auto* saved) { return NAME##_restore(o, saved); }; \
  };                                                                                               \
  void fly_##NAME(nlo::hostile::Bits& bits, long steps) {                                          \
    nlo::hostile::C99Craft<NAME##_calls> craft;                                                    \
    NAME##_init(&craft.observer);                                                                  \
    nlo::hostile::fly(craft, #NAME, bits, steps);                                                  \
  }
