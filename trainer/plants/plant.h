// SPDX-License-Identifier: MIT
// A plant to simulate: dx/dt = f(x, u), y = h(x) (1). Most plants are affine in u, f(x) + sum_j g_j(x) u_j (24), or
// have no input. Only the simulator, the baselines that know the model, and the PDE residual use a plant; training
// needs only data.
//
// To add one: a file of this folder with a function that makes it, and a line in plant_registry.cpp. Tests run over the
// registry.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model/model.h"

namespace nlo::trainer {

using PlantParameters = std::vector<std::pair<std::string, double>>;

class Plant {
 public:
  Plant(std::string name, std::vector<codegen::Channel> states, std::vector<codegen::Channel> outputs,
        std::vector<codegen::Channel> inputs = {})
      : name_(std::move(name)), states_(std::move(states)), outputs_(std::move(outputs)), inputs_(std::move(inputs)) {}
  virtual ~Plant() = default;
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  const std::string& name() const { return name_; }
  const std::vector<codegen::Channel>& states() const { return states_; }
  const std::vector<codegen::Channel>& outputs() const { return outputs_; }
  const std::vector<codegen::Channel>& inputs() const { return inputs_; }  ///< empty: the plant is autonomous
  Eigen::Index nx() const { return static_cast<Eigen::Index>(states_.size()); }
  Eigen::Index ny() const { return static_cast<Eigen::Index>(outputs_.size()); }
  Eigen::Index nu() const { return static_cast<Eigen::Index>(inputs_.size()); }

  /// Returns f(x) = f(x, 0), n_x x B for x n_x x B, one column per trajectory. A state outside of the domain of f gives
  /// NaN, never an exception. Two threads must not share a plant, because an expression plant evaluates in place: let
  /// each thread make its own.
  virtual Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const = 0;

  /// Returns h(x), n_y x B for x n_x x B.
  virtual Eigen::MatrixXd output(const Eigen::MatrixXd& x) const = 0;

  /// Returns f(x, u), n_x x B, for x n_x x B and u n_u x B, each column with its own u. If u is 0 x B, u = 0. Unless a
  /// plant overrides it, this is f(x) + sum_j g_j(x) u_j.
  virtual Eigen::MatrixXd driven_derivative(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) const;

  /// Returns true if f(x, u) is affine in u by its form. Otherwise driven_derivative() defines it.
  virtual bool affine_in_inputs() const { return true; }

  /// Returns g_j(x) of input j, n_x x B for x n_x x B; for u_j = 0 only f remains. A plant with inputs has one for
  /// each. If the plant is not affine in them, this is f(x, e_j) - f(x, 0).
  virtual Eigen::MatrixXd input_field(const Eigen::MatrixXd& /*x*/, Eigen::Index /*input*/) const {
    throw codegen::Error("plant " + name_ + " has no input field");
  }

 private:
  std::string name_;
  std::vector<codegen::Channel> states_, outputs_, inputs_;
};

/// Returns dimensionless channels with these names.
inline std::vector<codegen::Channel> channels(std::initializer_list<const char*> names) {
  std::vector<codegen::Channel> result;
  for (const char* name : names) result.push_back({name, "", 0.0});
  return result;
}

}  // namespace nlo::trainer
