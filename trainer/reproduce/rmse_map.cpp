// SPDX-License-Identifier: MIT
#include "trainer/reproduce/rmse_map.h"

#include <cmath>
#include <cstddef>

#include "codegen/replay/reference_observer.h"
#include "trainer/base/parallel.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {

Eigen::MatrixXd rmse_map(const codegen::Model& model, const PlantConfig& plant, const SimulationConfig& simulation,
                         const Eigen::VectorXd& x1, const Eigen::VectorXd& x2, int threads) {
  Eigen::MatrixXd map(x2.size(), x1.size());
  ThreadPool(threads).run(static_cast<int>(x2.size()), [&](int row, int) {
    Eigen::MatrixXd initial(2, x1.size());
    initial.row(0) = x1.transpose();
    initial.row(1).setConstant(x2[row]);
    const Dataset runs = simulate_from(*make_plant(plant), simulation, initial);
    codegen::ReferenceObserver<float> observer(model);
    for (Eigen::Index column = 0; column < x1.size(); ++column) {
      const Trajectory& run = runs.trajectories[static_cast<std::size_t>(column)];
      const Eigen::MatrixXd estimate = observer.run(run.outputs, {}, run.time_s, true).x_hat;
      map(row, column) = std::sqrt((run.states - estimate).squaredNorm() / static_cast<double>(run.samples()));
    }
  });
  return map;
}

}  // namespace nlo::trainer
