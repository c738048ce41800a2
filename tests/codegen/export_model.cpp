// SPDX-License-Identifier: MIT
// Writes the exports of an example model, for tests that compile them:
//   export_model                                           lists the examples
//   export_model EXAMPLE TARGET SCALAR NAME FILE [FACTOR]
//       EXAMPLE  or a model file
//       TARGET   a target of nlo export, or "model" for the model file
//       FACTOR   multiplies one weight of the last layer, or of the error head if there is one
//       SCALAR   or SCALAR,WEIGHTS or SCALAR,WEIGHTS,MAX_ERROR or SCALAR,WEIGHTS,MAX_ERROR,ROLES: float,bf16
#include <cstdio>
#include <exception>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "codegen/targets/observers_in.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/targets/target_registry.h"
#include "codegen/targets/write_export.h"
#include "tests/codegen/example_models.h"

int main(int argc, char** argv) {
  using namespace nlo::codegen;
  try {
    std::vector<Model> models = example_models();
    if (argc > 1) models.insert(models.end(), {large_model(), mixed_model(), encoder_model(), hidden_joint_model()});
    const bool is_file = argc > 1 && std::string_view(argv[1]).ends_with(".json");
    if (is_file) models = {read_model(argv[1])};
    for (Model& model : models) {
      if (argc == 1) std::printf("%s\n", model.name.c_str());
      if (argc < 6 || (!is_file && model.name != argv[1])) continue;
      Network& network = *networks(model).back().network;
      if (argc == 7) (model.error ? model.error->weights : network.layers.back().weights)(0, 0) *= std::stod(argv[6]);
      ExportOptions options;
      std::istringstream numbers(argv[3]);
      std::string scalar, weights = "float", max_error;
      std::getline(numbers, scalar, ',') && std::getline(numbers, weights, ',') &&
          std::getline(numbers, max_error, ',') && std::getline(numbers, options.roles);
      options.scalar = scalar_type(scalar);
      options.weights = weight_type(weights.empty() ? "float" : weights);
      options.name = argv[4];
      if (std::string(argv[2]) == "model") {
        write_model(model, argv[5]);
        return 0;
      }
      const ExportTarget& target = export_target(argv[2]);
      const std::vector<NamedText> files = target.generate(PreparedExport(model, options, max_error));
      check_export(target, files, argv[5]);
      write_export(target, files, argv[5]);
      return 0;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return argc == 1 ? 0 : 2;
}
