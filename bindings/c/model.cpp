// SPDX-License-Identifier: MIT
// The models of nlo_model.h, by the reader of model files and the reference observer. It contains no equation.
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "bindings/c/handles.h"
#include "codegen/base/file.h"
#include "codegen/model/latent_step.h"
#include "codegen/model_file/model_file.h"

using namespace nlo::c_interface;

namespace {

const nlo::codegen::Channel* channel_at(const nlo_model* model, int channel, int index) {
  if (model == nullptr) return nullptr;
  const auto* all = model->loaded->channels(channel);
  const bool exists = all != nullptr && index >= 0 && static_cast<std::size_t>(index) < all->size();
  return exists ? &(*all)[static_cast<std::size_t>(index)] : nullptr;
}

int size_of(const nlo_model* model, int (Model::*size)() const) {
  return model == nullptr ? 0 : (model->loaded->model.*size)();
}

nlo_model* loaded_from(std::string_view json, const std::string& origin) {
  return new nlo_model{std::make_shared<const Loaded>(nlo::codegen::parse_model(json, origin))};
}

}  // namespace

extern "C" {

int nlo_abi_version(void) {
  return NLO_MODEL_ABI;
}
const char* nlo_version(void) {
  return NLO_VERSION;
}

const char* nlo_status_text(int status) {
  switch (status) {
    case NLO_OK:
      return "ok";
    case NLO_CLAMPED:
      return "clamped";
    case NLO_HELD:
      return "held";
    case NLO_STALE:
      return "stale";
    case NLO_OUT_OF_RANGE:
      return "out of range";
    case NLO_REJECTED:
      return "rejected";
    case NLO_DIVERGED:
      return "diverged";
    case NLO_RESET:
      return "reset";
    default:
      return "";
  }
}

nlo_model* nlo_model_from_bytes(const void* bytes, size_t size) {
  return made<nlo_model>([&] {
    need(bytes, "bytes");
    return loaded_from({static_cast<const char*>(bytes), size}, "model");
  });
}

nlo_model* nlo_model_from_file(const char* path) {
  return made<nlo_model>([&] {
    need(path, "path");
    return loaded_from(nlo::codegen::read_file(path), path);
  });
}

void nlo_model_free(nlo_model* model) {
  delete model;
}

const char* nlo_model_name(const nlo_model* model) {
  return model == nullptr ? "" : model->loaded->model.name.c_str();
}
const char* nlo_model_structure(const nlo_model* model) {
  return model == nullptr ? "" : model->loaded->structure.c_str();
}
double nlo_model_sample_period_s(const nlo_model* model) {
  return model == nullptr ? 0.0 : model->loaded->model.sample_period_s;
}
int nlo_model_ny(const nlo_model* model) {
  return size_of(model, &Model::measured);
}
int nlo_model_nu(const nlo_model* model) {
  return size_of(model, &Model::nu);
}
int nlo_model_nx(const nlo_model* model) {
  return size_of(model, &Model::nx);
}
int nlo_model_nz(const nlo_model* model) {
  return size_of(model, &Model::nz);
}
int nlo_model_nr(const nlo_model* model) {
  return size_of(model, &Model::nr);
}
int nlo_model_has_sigma(const nlo_model* model) {
  return model != nullptr && model->loaded->model.error ? 1 : 0;
}

const char* nlo_model_channel_name(const nlo_model* model, int channel, int index) {
  const auto* found = channel_at(model, channel, index);
  return found == nullptr ? "" : found->name.c_str();
}
const char* nlo_model_channel_unit(const nlo_model* model, int channel, int index) {
  const auto* found = channel_at(model, channel, index);
  return found == nullptr ? "" : found->unit.c_str();
}
double nlo_model_channel_turn(const nlo_model* model, int channel, int index) {
  const auto* found = channel_at(model, channel, index);
  return found == nullptr ? 0.0 : found->wrap;
}

int nlo_model_channel_range(const nlo_model* model, int channel, int index, double* low, double* high) {
  return guarded(NLO_FAILED, [&] {
    need(model, "model");
    need(low, "low");
    need(high, "high");
    if (channel_at(model, channel, index) == nullptr) throw BadArgument("there is no such channel");
    const Loaded& loaded = *model->loaded;
    *high = std::numeric_limits<double>::infinity();
    *low = -*high;
    if (channel == NLO_OUTPUT) {
      *low = loaded.model.output_min(index);
      *high = loaded.model.output_max(index);
    } else if (channel == NLO_INPUT) {
      *low = loaded.input_min(index);
      *high = loaded.input_max(index);
    }
    return NLO_DONE;
  });
}

const char* nlo_model_json(const nlo_model* model) {
  return model == nullptr ? "" : model->loaded->json.c_str();
}

int nlo_model_linear_latent(const nlo_model* model, double* d, double* f) {
  return guarded(NLO_FAILED, [&] {
    need(model, "model");
    need(d, "d");
    need(f, "f");
    using ByRow = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
    const Model& m = model->loaded->model;
    const auto* latent = linear_latent(m);
    if (latent == nullptr)
      throw NotKnown("z of \"" + m.name + "\" (" + model->loaded->structure + ") does not run as D z + F y");
    ByRow(d, m.nz(), m.nz()) = block_diagonal(m, latent->eigenvalues);
    ByRow(f, m.nz(), m.nr()) = latent->output_injection;
    return NLO_DONE;
  });
}

int nlo_model_inverse_map(const nlo_model* model, int precision, size_t count, const double* z, const double* readings,
                          double* x_hat) {
  return guarded(NLO_FAILED, [&] {
    need(model, "model");
    need(z, "z");
    need(x_hat, "x_hat");
    const Model& m = model->loaded->model;
    const auto* map = inverse_map(m);
    if ((map != nullptr && map->inputs() > m.nz()) || saturates_relative(m))
      need(readings, "readings, which T* reads,");
    const Eigen::Index samples = columns(count);
    MatrixXd y = MatrixXd::Zero(m.nr(), samples);
    if (readings != nullptr) y = ConstRows(readings, m.nr(), samples);
    Rows(x_hat, m.nx(), samples) = std::visit(
        [&](const auto& o) { return o.estimates(ConstRows(z, m.nz(), samples), y); }, observer_of(m, precision));
    return NLO_DONE;
  });
}

int nlo_model_run(const nlo_model* model, int precision, size_t samples, const double* y, const double* u,
                  const double* time_s, double* x_hat, double* sigma, double* z, int32_t* status, uint8_t* in_domain) {
  return guarded(NLO_FAILED, [&] {
    need(model, "model");
    const Loaded& loaded = *model->loaded;
    const Model& m = loaded.model;
    if (sigma != nullptr && !m.error) throw NotKnown("\"" + m.name + "\" has no sigma");
    const Eigen::Index n = columns(samples);
    AnyObserver observer = observer_of(m, precision);
    if (n == 0) return NLO_DONE;
    need(y, "y");
    VectorXd stamps;
    if (time_s != nullptr) stamps = Eigen::Map<const VectorXd>(time_s, n);
    const nlo::codegen::Run run = std::visit(
        [&](auto& o) {
          return o.run(loaded.with_computed(y, n), loaded.given_inputs(u, n), stamps, time_s == nullptr,
                       nlo::codegen::Angles::kWrapped);
        },
        observer);
    if (x_hat != nullptr) Rows(x_hat, m.nx(), n) = run.x_hat;
    if (sigma != nullptr) Rows(sigma, m.nx(), n) = run.sigma;
    if (z != nullptr) Rows(z, m.nz(), n) = run.z;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (status != nullptr) status[k] = static_cast<std::int32_t>(run.status[static_cast<std::size_t>(k)]);
      if (in_domain != nullptr) in_domain[k] = run.in_domain[static_cast<std::size_t>(k)] ? 1 : 0;
    }
    return NLO_DONE;
  });
}

}  // extern "C"
