// SPDX-License-Identifier: MIT
// The deterministic policy of the C++ runtime behind the header of a C99 export. Linked instead of NAME.c, it gives the
// bits that NAME.c must give. With NLO_C99_SINGLE it wraps the single header, whose class has the same members.
//   NLO_C99_SHIM(rig, float)           // after including both headers of the name
//   NLO_C99_DRIVEN_SHIM(motor, float)  // if it reads inputs
//   NLO_C99_WARM_SHIM(rig, float)      // if it has a steady state; NLO_C99_DRIVEN_WARM_SHIM: of y and u
#pragma once

#include <bit>
#include <cstring>
#include <type_traits>

#ifndef NLO_C99_SINGLE
#include "nlo/kkl_observer.h"
#include "nlo/monitor.h"
#include "nlo/sampled_observer.h"
#endif

namespace nlo::shim {

#ifdef NLO_C99_SINGLE
/// A C++ observer that continues from a C observer and writes its state back.
template <class State, class Single>
class Resumed {
 public:
  using Observer = Single;

  explicit Resumed(State& state) : observer(std::bit_cast<Observer>(state)), state_(state) {
    Observer fresh;
    good = fresh.restore(observer.save());
    if (good) observer = fresh;
  }
  void write() { state_ = std::bit_cast<State>(observer.save()); }
  template <class Status, class Given>
  Status written(Given status) {
    write();
    return static_cast<Status>(status);
  }

  Observer observer;
  bool good;

 private:
  State& state_;
};
#else
/// The observer of the runtime, continued from a state.
template <class State, class Model>
class Resumed {
 public:
  /// An observer of any structure that also accepts states that restore() refuses, such as memory with a flipped bit.
  struct Observer : SampledObserver<Model, Arithmetic::kDeterministic> {
    using Base = SampledObserver<Model, Arithmetic::kDeterministic>;
    using Base::Base;
    void put(const typename Base::State& state) { this->state_ = state; }
  };

  Resumed(State& state, const Model& model) : observer(model), state_(state) {
    typename Observer::State from{};
    std::memcpy(from.z, state.z, sizeof(from.z));
    std::memcpy(from.y, state.y, sizeof(from.y));
    if constexpr (Observer::kActing > 0) std::memcpy(from.input.u, state.y + Observer::kNr, sizeof(from.input.u));
    std::memcpy(from.health, state.health, sizeof(from.health));
    from.status = static_cast<StepStatus>(state.status);
    from.started = state.started;
    good = observer.restore(from);
    if (!good) observer.put(from);
  }
  void write() {
    const typename Observer::State now = observer.save();
    std::memcpy(state_.z, now.z, sizeof(now.z));
    std::memcpy(state_.y, now.y, sizeof(now.y));
    if constexpr (Observer::kActing > 0) std::memcpy(state_.y + Observer::kNr, now.input.u, sizeof(now.input.u));
    std::memcpy(state_.health, now.health, sizeof(now.health));
    state_.status = static_cast<std::uint8_t>(now.status);
    state_.started = now.started;
  }
  template <class Status, class Given>
  Status written(Given status) {
    write();
    return static_cast<Status>(status);
  }

  Observer observer;
  bool good;

 private:
  State& state_;
};
#endif

#ifndef NLO_C99_SINGLE
/// The monitor of the runtime, continued from a C monitor, even if restore() would refuse it.
template <class C, class Model>
struct ResumedMonitor {
  using Monitor = nlo::Monitor<Model, Arithmetic::kDeterministic>;
  ResumedMonitor(C& from, const Model& model) : c(from), monitor(model) {
    static_assert(sizeof(C) == sizeof(typename Monitor::State) && sizeof(monitor) >= sizeof(void*) + sizeof(C));
    std::memcpy(reinterpret_cast<char*>(&monitor) + sizeof(void*), &c, sizeof(C));
  }
  void write() { c = std::bit_cast<C>(monitor.save()); }
  C& c;
  Monitor monitor;
};
#else
template <class C, class Single>
struct ResumedMonitor {
  explicit ResumedMonitor(C& from) : c(from), monitor(std::bit_cast<Single>(from)) {}
  void write() { c = std::bit_cast<C>(monitor); }
  C& c;
  Single monitor;
};
#endif

template <class Output, class Scalar>
Output output(const Scalar* y) {
  Output values{};
  for (decltype(values.size()) j = 0; j < values.size(); ++j) values[j] = y[j];
  return values;
}

}  // namespace nlo::shim

#ifdef NLO_C99_SINGLE
#define NLO_C99_BEHIND(name) nlo::single::name::Observer
#define NLO_C99_MODEL(name)
#define NLO_C99_MONITOR(name) nlo::single::name::Monitor
#define NLO_C99_WATCH(name)
#else
#define NLO_C99_BEHIND(name) nlo::name::Model
#define NLO_C99_MODEL(name) , nlo::name::kModel
#define NLO_C99_MONITOR(name) nlo::name::MonitorModel
#define NLO_C99_WATCH(name) , nlo::name::kMonitor
#endif

#define NLO_C99_SHIM_OF(name, Scalar, U, AND_U, ONLY_U)                                                            \
  namespace {                                                                                                      \
  using name##_resumed = nlo::shim::Resumed<name##_observer, NLO_C99_BEHIND(name)>;                                \
  using name##_output = name##_resumed::Observer::Output;                                                          \
  }                                                                                                                \
  void name##_reset(name##_observer* o) {                                                                          \
    *o = {};                                                                                                       \
    name##_resumed resumed(*o NLO_C99_MODEL(name));                                                                \
    resumed.observer.reset();                                                                                      \
    resumed.write();                                                                                               \
  }                                                                                                                \
  void name##_init(name##_observer* o) {                                                                           \
    name##_reset(o);                                                                                               \
  }                                                                                                                \
  name##_status name##_step(name##_observer* o, const Scalar* y U(Scalar)) {                                       \
    name##_resumed resumed(*o NLO_C99_MODEL(name));                                                                \
    return resumed.written<name##_status>(resumed.observer.step(nlo::shim::output<name##_output>(y) AND_U(name))); \
  }                                                                                                                \
  name##_status name##_step_dt(name##_observer* o, const Scalar* y U(Scalar), Scalar dt_s) {                       \
    name##_resumed resumed(*o NLO_C99_MODEL(name));                                                                \
    return resumed.written<name##_status>(                                                                         \
        resumed.observer.step(nlo::shim::output<name##_output>(y) AND_U(name), dt_s));                             \
  }                                                                                                                \
  name##_status name##_step_missed(name##_observer* o U(Scalar)) {                                                 \
    name##_resumed resumed(*o NLO_C99_MODEL(name));                                                                \
    return resumed.written<name##_status>(resumed.observer.step_missed(ONLY_U(name)));                             \
  }                                                                                                                \
  void name##_estimate(const name##_observer* o, Scalar* x_hat) {                                                  \
    name##_observer copy = *o;                                                                                     \
    const auto estimate = name##_resumed(copy NLO_C99_MODEL(name)).observer.estimate();                            \
    for (decltype(estimate.size()) i = 0; i < estimate.size(); ++i) x_hat[i] = estimate[i];                        \
  }                                                                                                                \
  name##_status name##_last_status(const name##_observer* o) {                                                     \
    name##_observer copy = *o;                                                                                     \
    return static_cast<name##_status>(name##_resumed(copy NLO_C99_MODEL(name)).observer.status());                 \
  }                                                                                                                \
  name##_status name##_status_of(const name##_observer* o, int channel) {                                          \
    name##_observer copy = *o;                                                                                     \
    return static_cast<name##_status>(name##_resumed(copy NLO_C99_MODEL(name)).observer.status(channel));          \
  }                                                                                                                \
  bool name##_in_domain(const name##_observer* o) {                                                                \
    name##_observer copy = *o;                                                                                     \
    return name##_resumed(copy NLO_C99_MODEL(name)).observer.in_domain();                                          \
  }                                                                                                                \
  bool name##_restore(name##_observer* o, const name##_observer* saved) {                                          \
    name##_observer copy = *saved;                                                                                 \
    const bool good = name##_resumed(copy NLO_C99_MODEL(name)).good;                                               \
    if (good) *o = copy;                                                                                           \
    return good;                                                                                                   \
  }

#define NLO_C99_WARM_SHIM_OF(name, Scalar, U, AND_U)                                   \
  name##_status name##_warm_start(name##_observer* o, const Scalar* y U(Scalar)) {     \
    name##_resumed resumed(*o NLO_C99_MODEL(name));                                    \
    return resumed.written<name##_status>(                                             \
        resumed.observer.warm_start(nlo::shim::output<name##_output>(y) AND_U(name))); \
  }

#define NLO_C99_WATCHED_SHIM(name, Scalar)                                                                       \
  namespace {                                                                                                    \
  using name##_resumed_monitor = nlo::shim::ResumedMonitor<name##_monitor, NLO_C99_MONITOR(name)>;               \
  }                                                                                                              \
  void name##_monitor_reset(name##_monitor* m) {                                                                 \
    *m = {};                                                                                                     \
    name##_resumed_monitor resumed(*m NLO_C99_WATCH(name));                                                      \
    resumed.monitor.reset();                                                                                     \
    resumed.write();                                                                                             \
  }                                                                                                              \
  void name##_usable_outputs(name##_monitor* m, const name##_observer* o, const Scalar* y, Scalar* kept) {       \
    name##_observer copy = *o;                                                                                   \
    const name##_resumed observer(copy NLO_C99_MODEL(name));                                                     \
    name##_resumed_monitor resumed(*m NLO_C99_WATCH(name));                                                      \
    const auto trusted = resumed.monitor.usable_outputs(nlo::shim::output<name##_output>(y), observer.observer); \
    resumed.write();                                                                                             \
    for (decltype(trusted.size()) j = 0; j < trusted.size(); ++j) kept[j] = trusted[j];                          \
  }                                                                                                              \
  name##_alarm name##_watch(name##_monitor* m, const name##_observer* o, const Scalar* x_hat) {                  \
    name##_observer copy = *o;                                                                                   \
    const name##_resumed observer(copy NLO_C99_MODEL(name));                                                     \
    name##_resumed_monitor resumed(*m NLO_C99_WATCH(name));                                                      \
    const auto alarm =                                                                                           \
        resumed.monitor.watch(observer.observer, nlo::shim::output<name##_resumed::Observer::Estimate>(x_hat));  \
    resumed.write();                                                                                             \
    return static_cast<name##_alarm>(alarm);                                                                     \
  }                                                                                                              \
  bool name##_monitor_armed(const name##_monitor* m) {                                                           \
    name##_monitor copy = *m;                                                                                    \
    return name##_resumed_monitor(copy NLO_C99_WATCH(name)).monitor.armed();                                     \
  }                                                                                                              \
  bool name##_monitor_restore(name##_monitor* m, const name##_monitor* saved) {                                  \
    name##_monitor copy = *saved;                                                                                \
    name##_resumed_monitor from(copy NLO_C99_WATCH(name)), resumed(*m NLO_C99_WATCH(name));                      \
    const bool good = resumed.monitor.restore(from.monitor.save());                                              \
    resumed.write();                                                                                             \
    return good;                                                                                                 \
  }

#define NLO_C99_NOTHING(any)
#define NLO_C99_U(Scalar) , const Scalar* u
#define NLO_C99_ONLY_U(name) nlo::shim::output<name##_resumed::Observer::Input>(u)
#define NLO_C99_AND_U(name) , NLO_C99_ONLY_U(name)
#define NLO_C99_SHIM(name, Scalar) NLO_C99_SHIM_OF(name, Scalar, NLO_C99_NOTHING, NLO_C99_NOTHING, NLO_C99_NOTHING)
#define NLO_C99_DRIVEN_SHIM(name, Scalar) NLO_C99_SHIM_OF(name, Scalar, NLO_C99_U, NLO_C99_AND_U, NLO_C99_ONLY_U)
#define NLO_C99_WARM_SHIM(name, Scalar) NLO_C99_WARM_SHIM_OF(name, Scalar, NLO_C99_NOTHING, NLO_C99_NOTHING)
#define NLO_C99_DRIVEN_WARM_SHIM(name, Scalar) NLO_C99_WARM_SHIM_OF(name, Scalar, NLO_C99_U, NLO_C99_AND_U)
