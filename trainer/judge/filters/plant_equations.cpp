// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/plant_equations.h"

#include <algorithm>
#include <utility>

#include "trainer/plants/equations_of_plant.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double& value_of(PlantConfig& plant, const std::string& parameter) {
  return std::find_if(plant.parameters.begin(), plant.parameters.end(),
                      [&](const auto& entry) { return entry.first == parameter; })
      ->second;
}

/// Extends f and h to any parameters, as functions that are affine in them: one plant for each parameter, with this
/// parameter changed by a quarter.
class AffinePlant {
 public:
  AffinePlant(const PlantConfig& config, const std::vector<std::string>& names) {
    PlantConfig known = config;
    for (const std::string& name : names) {
      nominal_.push_back(value_of(known, name));
      steps_.push_back(nominal_.back() != 0.0 ? 0.25 * nominal_.back() : 0.25);
    }
    plants_.push_back(make_plant(known));
    for (std::size_t i = 0; i < names.size(); ++i) {
      PlantConfig moved = known;
      value_of(moved, names[i]) += steps_[i];
      plants_.push_back(make_plant(moved));
    }
  }

  const Plant& plant() const { return *plants_.front(); }

  /// Evaluates `map` of the plant with the parameters of each point, which are below its states.
  template <class Map>
  MatrixXd value(const MatrixXd& points, const Map& map) const {
    const Index nx = plants_.front()->nx();
    const MatrixXd x = points.topRows(nx), base = map(*plants_.front(), x);
    MatrixXd result = base;
    for (std::size_t i = 0; i < nominal_.size(); ++i) {
      const Eigen::RowVectorXd share = (points.row(nx + static_cast<Index>(i)).array() - nominal_[i]) / steps_[i];
      result += (map(*plants_[i + 1], x) - base) * share.asDiagonal();
    }
    return result;
  }

 private:
  std::vector<std::unique_ptr<Plant>> plants_;
  std::vector<double> nominal_, steps_;
};

MatrixXd driven(const Plant& plant, const MatrixXd& x, const MatrixXd& u) {
  return u.size() == 0 ? plant.derivative(x) : plant.driven_derivative(x, u);
}

MatrixXd with_still_parameters(const MatrixXd& f, Index parameters) {
  MatrixXd all = MatrixXd::Zero(f.rows() + parameters, f.cols());
  all.topRows(f.rows()) = f;
  return all;
}

/// Returns true if the affine extension is exact: it equals the plant for changed values of all parameters.
bool is_exact(const AffinePlant& affine, const PlantConfig& plant, const std::vector<std::string>& names,
              const MatrixXd& initial) {
  for (const double factor : {0.6, 1.7}) {
    PlantConfig moved = plant;
    MatrixXd points(initial.rows() + static_cast<Index>(names.size()), initial.cols());
    points.topRows(initial.rows()) = initial;
    for (std::size_t i = 0; i < names.size(); ++i) {
      double& value = value_of(moved, names[i]);
      value = value != 0.0 ? value * factor : factor;
      points.row(initial.rows() + static_cast<Index>(i)).setConstant(value);
    }
    const auto truth = make_plant(moved);
    const MatrixXd f = truth->derivative(initial), h = truth->output(initial);
    const MatrixXd own_f = affine.value(points, [](const Plant& p, const MatrixXd& x) { return p.derivative(x); });
    const MatrixXd own_h = affine.value(points, [](const Plant& p, const MatrixXd& x) { return p.output(x); });
    constexpr double kRounding = 1e-10;
    if (!((own_f - f).norm() <= kRounding * (1.0 + f.norm()) && (own_h - h).norm() <= kRounding * (1.0 + h.norm())))
      return false;
  }
  return true;
}

}  // namespace

LanePlant joint_plant(const PlantConfig& plant, const std::vector<std::string>& parameters, const MatrixXd& initial) {
  PlantConfig known = plant;
  if (!known.model.empty()) known.parameters = equations_of(plant).parameters;  // with their default values
  known.parameter_ranges.clear();
  const auto np = static_cast<Index>(parameters.size());
  const auto affine = std::make_shared<const AffinePlant>(known, parameters);
  LanePlant joint;
  if (is_exact(*affine, known, parameters, initial)) {
    joint.f = [affine, np](const MatrixXd& points, const MatrixXd& u) {
      return with_still_parameters(
          affine->value(points, [&](const Plant& p, const MatrixXd& x) { return driven(p, x, u); }), np);
    };
    joint.h = [affine](const MatrixXd& points, const MatrixXd&) {
      return affine->value(points, [](const Plant& p, const MatrixXd& x) { return p.output(x); });
    };
    joint.ny = affine->plant().ny();
    joint.nx = affine->plant().nx() + np;
  } else {
    PlantConfig extended = equations_of(known);
    for (const std::string& name : parameters) {
      extended.states.push_back(name);
      extended.derivative.emplace_back("0");
      if (!extended.input_field.empty()) extended.input_field.emplace_back(extended.input_field.front().size(), "0");
      if (!extended.state_wraps.empty()) extended.state_wraps.push_back(0.0);
      if (!extended.state_units.empty()) extended.state_units.emplace_back();
      std::erase_if(extended.parameters, [&](const auto& entry) { return entry.first == name; });
    }
    extended.state_encodings.clear();
    extended.estimated.clear();
    joint = lane_plant(make_plant(extended));
  }
  joint.output_wraps = lane_plant(make_plant(known)).output_wraps;
  return joint;
}

}  // namespace nlo::trainer
