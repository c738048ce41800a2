// SPDX-License-Identifier: MIT
// The objects behind the pointers of nlo_model.h, and the conversion of exceptions into a code and a text.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bindings/c/nlo_model.h"
#include "bindings/c/step_memory.h"
#include "codegen/base/error.h"
#include "codegen/model/domain.h"
#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"

namespace nlo::c_interface {

using codegen::Model;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using ConstRows = Eigen::Map<const MatrixXd>;  // a sample is a column in Eigen's order: the same memory
using Rows = Eigen::Map<MatrixXd>;

struct BadArgument : codegen::Error {
  using Error::Error;
};
struct NotKnown : codegen::Error {
  using Error::Error;
};

/// Stores an error for nlo_last_error() and returns `code`.
int keep(int code, const char* text) noexcept;

/// Runs `work`. If it throws, stores the text and returns a code. `code_of_error`: the code of an Error without its
/// own.
template <class Work>
int guarded(int code_of_error, Work&& work) noexcept {
  try {
    return std::forward<Work>(work)();
  } catch (const BadArgument& error) {
    return keep(NLO_BAD_ARGUMENT, error.what());
  } catch (const NotKnown& error) {
    return keep(NLO_NOT_KNOWN, error.what());
  } catch (const codegen::Error& error) {
    return keep(code_of_error, error.what());
  } catch (const std::bad_alloc&) {
    return keep(NLO_NO_MEMORY, "no memory left");
  } catch (const std::exception& error) {
    return keep(NLO_FAILED, error.what());
  } catch (...) {
    return keep(NLO_FAILED, "an error without a text");
  }
}

/// Runs `work`, which makes an object. Returns null if it throws.
template <class Made, class Work>
Made* made(Work&& work) noexcept {
  Made* result = nullptr;
  guarded(NLO_BAD_MODEL, [&] {
    result = work();
    return NLO_DONE;
  });
  return result;
}

template <class Pointer>
void need(Pointer pointer, const char* name) {
  if (pointer == nullptr) throw BadArgument(std::string(name) + " is NULL");
}

/// Data that a model shares with its observers.
struct Loaded {
  std::string json, structure;
  Model model;  ///< without recorded training runs, because every observer copies the model
  std::vector<codegen::Channel> outputs, inputs;
  VectorXd input_min, input_max;

  explicit Loaded(Model read);

  /// Returns null if there is no such kind.
  const std::vector<codegen::Channel>* channels(int kind) const;

  /// Returns the outputs y of samples and rows for the computed outputs, n_y x N.
  MatrixXd with_computed(const double* y, Eigen::Index samples) const;

  /// Returns the inputs, n_u x N; 0 x N if there are none.
  MatrixXd given_inputs(const double* u, Eigen::Index samples) const;
};

using AnyObserver = std::variant<codegen::ReferenceObserver<float>, codegen::ReferenceObserver<double>>;
AnyObserver observer_of(const Model& model, int precision);

/// Throws BadArgument if there cannot be so many samples.
Eigen::Index columns(std::size_t count);

}  // namespace nlo::c_interface

struct nlo_model {
  std::shared_ptr<const nlo::c_interface::Loaded> loaded;
};

struct nlo_observer {
  std::shared_ptr<const nlo::c_interface::Loaded> loaded;
  int precision;
  nlo::c_interface::AnyObserver any;
  std::unique_ptr<nlo::c_interface::StepMemory> memory;  ///< null while it is being made

  nlo_observer(std::shared_ptr<const nlo::c_interface::Loaded> of, int wanted)
      : loaded(std::move(of)), precision(wanted), any(nlo::c_interface::observer_of(loaded->model, wanted)) {}
};
