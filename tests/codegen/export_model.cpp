// SPDX-License-Identifier: MIT
// Writes the exports of an example model, for tests that compile them:
//   export_model                                           lists the examples
//   export_model EXAMPLE TARGET SCALAR NAME FILE [FACTOR]  TARGET model: its model file; spoilt: times FACTOR on one
//   weight of a last layer
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "codegen/model_file.h"
#include "codegen/targets/registry.h"
#include "codegen/targets/write_export.h"
#include "tests/codegen/example_models.h"

int main(int argc, char** argv) {
  using namespace nlo::codegen;
  try {
    for (Model& model : example_models()) {
      if (argc == 1) std::printf("%s\n", model.name.c_str());
      if (argc < 6 || model.name != argv[1]) continue;
      Network& network = model.luenberger ? model.luenberger->nonlinearity
                         : model.dynamics ? *model.dynamics
                         : model.drive    ? model.drive->forward_map
                                          : model.inverse_map;
      if (argc == 7) network.layers.back().weights(0, 0) *= std::stod(argv[6]);
      ExportOptions options;
      options.scalar = scalar_type(argv[3]);
      options.name = argv[4];
      if (std::string(argv[2]) == "model") {
        write_model(model, argv[5]);
        return 0;
      }
      const ExportTarget& target = export_target(argv[2]);
      const std::vector<NamedText> files = target.generate(model, options);
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
