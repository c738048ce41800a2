// SPDX-License-Identifier: MIT
// Observers of nlo_model.h: the reference observer, step by step.
#include <memory>
#include <variant>

#include "bindings/c/handles.h"

using namespace nlo::c_interface;

namespace {

VectorXd latent_of(const nlo_observer& observer) {
  return std::visit([](const auto& o) { return VectorXd(o.latent().template cast<double>()); }, observer.any);
}
const VectorXd& output_of(const nlo_observer& observer) {
  return std::visit([](const auto& o) -> const VectorXd& { return o.output(); }, observer.any);
}
VectorXd state_of(const nlo_observer& observer) {
  return std::visit([](const auto& o) { return o.snapshot(); }, observer.any);
}

/// `step` of the observer with the vectors of a sample.
template <class Step>
int stepped(nlo_observer* observer, const double* y, const double* u, const Step& step) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
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
    return new nlo_observer(model->loaded, precision);
  });
}

nlo_observer* nlo_observer_copy(const nlo_observer* observer) {
  return made<nlo_observer>([&] {
    need(observer, "observer");
    auto copy = std::make_unique<nlo_observer>(observer->loaded, observer->precision);
    std::visit([&](auto& o) { o.restore(state_of(*observer)); }, copy->any);
    return copy.release();
  });
}

void nlo_observer_free(nlo_observer* observer) {
  delete observer;
}

int nlo_observer_reset(nlo_observer* observer) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
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
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
    return std::visit([](const auto& o) { return static_cast<int>(o.status()); }, observer->any);
  });
}

int nlo_observer_in_domain(const nlo_observer* observer) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
    return observer->domain.contains(latent_of(*observer), output_of(*observer)) ? 1 : 0;
  });
}

int nlo_observer_estimate(const nlo_observer* observer, double* x_hat) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
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
  return guarded(NLO_FAILED, [&] {
    need(sigma, "sigma");
    const Model& m = observer->loaded->model;
    if (!m.error) throw NotKnown("\"" + m.name + "\" has no sigma");
    Rows(sigma, m.nx(), 1) = std::visit(
        [&](const auto& o) { return o.deviations(latent_of(*observer), output_of(*observer)); }, observer->any);
    return NLO_DONE;
  });
}

int nlo_observer_latent(const nlo_observer* observer, double* z) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
    need(z, "z");
    Rows(z, observer->loaded->model.nz(), 1) = latent_of(*observer);
    return NLO_DONE;
  });
}

int nlo_observer_state_size(const nlo_observer* observer) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
    return std::visit([](const auto& o) { return static_cast<int>(o.snapshot_size()); }, observer->any);
  });
}

int nlo_observer_save(const nlo_observer* observer, double* state) {
  return guarded(NLO_FAILED, [&] {
    need(observer, "observer");
    need(state, "state");
    const VectorXd all = state_of(*observer);
    Rows(state, all.size(), 1) = all;
    return NLO_DONE;
  });
}

int nlo_observer_restore(nlo_observer* observer, const double* state, size_t size) {
  return guarded(NLO_BAD_ARGUMENT, [&] {
    need(observer, "observer");
    need(state, "state");
    const VectorXd given = Eigen::Map<const VectorXd>(state, columns(size));
    std::visit([&](auto& o) { o.restore(given); }, observer->any);
    return NLO_DONE;
  });
}

}  // extern "C"
