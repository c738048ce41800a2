// SPDX-License-Identifier: MIT
// Observers of nlo_model.h: the reference observer, step by step.
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <variant>

#include "bindings/c/handles.h"

using namespace nlo::c_interface;

namespace {

VectorXd latent_of(const nlo_observer& observer) {
  return std::visit([](const auto& o) { return VectorXd(o.latent().template cast<double>()); }, observer.any);
}
VectorXd state_of(const nlo_observer& observer) {
  return std::visit([](const auto& o) { return o.snapshot(); }, observer.any);
}

/// Runs guarded() `work` on the observer with allocations from its memory. Exceptions are allocated there, too.
template <class Observer, class Work>
int on(Observer* observer, const Work& work, int code_of_error = NLO_FAILED) noexcept {
  const StepMemory::Use memory(observer == nullptr ? nullptr : observer->memory.get());
  return guarded(code_of_error, [&] {
    need(observer, "observer");
    return work();
  });
}

/// Calls each function that a user may call once, from a first sample to a reset.
void exercise(nlo_observer& observer) {
  const Loaded& loaded = *observer.loaded;
  const Model& m = loaded.model;
  const VectorXd u = VectorXd::Zero(m.nu());
  VectorXd y = 0.5 * (m.output_min + m.output_max), x_hat(m.nx()), sigma(m.nx()), z(m.nz()),
           state(nlo_observer_state_size(&observer));
  const auto ask = [&] {
    nlo_observer_estimate(&observer, x_hat.data());
    if (m.error) nlo_observer_estimate_with_error(&observer, x_hat.data(), sigma.data());
    nlo_observer_in_domain(&observer);
    nlo_observer_latent(&observer, z.data());
    nlo_observer_save(&observer, state.data());
    nlo_observer_restore(&observer, state.data(), static_cast<std::size_t>(state.size()));
  };
  constexpr double kOther[] = {1.5, 3.5};  // sample periods
  nlo_observer_step(&observer, y.data(), u.data());
  nlo_observer_step(&observer, y.data(), u.data());
  for (const double periods : kOther) nlo_observer_step_dt(&observer, y.data(), u.data(), periods * m.sample_period_s);
  ask();
  y.setConstant(std::numeric_limits<double>::quiet_NaN());
  nlo_observer_step(&observer, y.data(), u.data());
  ask();
  nlo_observer_reset(&observer);
}

struct Free {  // frees the vectors before the memory in which they may be
  void operator()(nlo_observer* observer) const { nlo_observer_free(observer); }
};

/// Makes enough memory for exercise(). If more is needed, it comes from the system.
nlo_observer* with_memory(const std::shared_ptr<const Loaded>& loaded, int precision) {
  constexpr std::size_t kFirst = std::size_t{1} << 15, kMost = std::size_t{1} << 28;
  for (std::size_t bytes = kFirst;; bytes *= 2) {
    std::unique_ptr<nlo_observer, Free> observer(new nlo_observer(loaded, precision));
    // The first run is without this memory: some allocations at the first step of a process do not belong to this
    // observer.
    exercise(*observer);
    observer->memory = std::make_unique<StepMemory>(bytes);
    exercise(*observer);
    if (!observer->memory->ran_out() || bytes >= kMost) return observer.release();
  }
}

/// Calls `step` of the observer with the vectors of a sample.
template <class Step>
int stepped(nlo_observer* observer, const double* y, const double* u, const Step& step) {
  return on(observer, [&] {
    need(y, "y");
    const VectorXd outputs = observer->loaded->with_computed(y, 1), inputs = observer->loaded->given_inputs(u, 1);
    return std::visit(
        [&](auto& o) {
          step(o, outputs, inputs);
          return static_cast<int>(o.status());
        },
        observer->any);
  });
}

}  // namespace

extern "C" {

nlo_observer* nlo_observer_create(const nlo_model* model, int precision) {
  return made<nlo_observer>([&] {
    need(model, "model");
    return with_memory(model->loaded, precision);
  });
}

nlo_observer* nlo_observer_copy(const nlo_observer* observer) {
  return made<nlo_observer>([&] {
    need(observer, "observer");
    const VectorXd state = state_of(*observer);
    nlo_observer* copy = with_memory(observer->loaded, observer->precision);
    nlo_observer_restore(copy, state.data(), static_cast<std::size_t>(state.size()));
    return copy;
  });
}

void nlo_observer_free(nlo_observer* observer) {
  if (observer == nullptr) return;
  const std::unique_ptr<StepMemory> memory = std::move(observer->memory);  // its vectors may be in it
  const StepMemory::Use use(memory.get());
  delete observer;
}

int nlo_observer_reset(nlo_observer* observer) {
  return on(observer, [&] {
    std::visit([](auto& o) { o.reset(); }, observer->any);
    return NLO_DONE;
  });
}

int nlo_observer_step(nlo_observer* observer, const double* y, const double* u) {
  return stepped(observer, y, u, [](auto& o, const VectorXd& at, const VectorXd& given) { o.step(at, given); });
}

int nlo_observer_step_dt(nlo_observer* observer, const double* y, const double* u, double dt_s) {
  return stepped(observer, y, u, [&](auto& o, const VectorXd& at, const VectorXd& given) { o.step(at, given, dt_s); });
}

int nlo_observer_status(const nlo_observer* observer) {
  return on(observer,
            [&] { return std::visit([](const auto& o) { return static_cast<int>(o.status()); }, observer->any); });
}

int nlo_observer_in_domain(const nlo_observer* observer) {
  return on(observer, [&] { return std::visit([](const auto& o) { return o.in_domain() ? 1 : 0; }, observer->any); });
}

int nlo_observer_estimate(const nlo_observer* observer, double* x_hat) {
  return on(observer, [&] {
    need(x_hat, "x_hat");
    std::visit(
        [&](const auto& o) { Rows(x_hat, observer->loaded->model.nx(), 1) = o.estimate().template cast<double>(); },
        observer->any);
    return NLO_DONE;
  });
}

int nlo_observer_estimate_with_error(const nlo_observer* observer, double* x_hat, double* sigma) {
  const int done = nlo_observer_estimate(observer, x_hat);
  if (done != NLO_DONE) return done;
  return on(observer, [&] {
    need(sigma, "sigma");
    const Model& m = observer->loaded->model;
    if (!m.error) throw NotKnown("\"" + m.name + "\" has no sigma");
    Rows(sigma, m.nx(), 1) =
        std::visit([&](const auto& o) { return o.deviations(latent_of(*observer), o.output(), {o.error_is_known()}); },
                   observer->any);
    return NLO_DONE;
  });
}

int nlo_observer_latent(const nlo_observer* observer, double* z) {
  return on(observer, [&] {
    need(z, "z");
    Rows(z, observer->loaded->model.nz(), 1) = latent_of(*observer);
    return NLO_DONE;
  });
}

int nlo_observer_state_size(const nlo_observer* observer) {
  return on(observer, [&] {
    return std::visit([](const auto& o) { return static_cast<int>(o.snapshot_size()); }, observer->any);
  });
}

int nlo_observer_save(const nlo_observer* observer, double* state) {
  return on(observer, [&] {
    need(state, "state");
    const VectorXd all = state_of(*observer);
    Rows(state, all.size(), 1) = all;
    return NLO_DONE;
  });
}

int nlo_observer_restore(nlo_observer* observer, const double* state, size_t size) {
  const auto restored = [&] {
    need(state, "state");
    const VectorXd given = Eigen::Map<const VectorXd>(state, columns(size));
    std::visit([&](auto& o) { o.restore(given); }, observer->any);
    return NLO_DONE;
  };
  return on(observer, restored, NLO_BAD_ARGUMENT);
}

}  // extern "C"
