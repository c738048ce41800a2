// SPDX-License-Identifier: MIT
#include "codegen/targets/target_registry.h"

#include "codegen/base/error.h"
#include "codegen/targets/around_c99.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/cpp_header.h"
#include "codegen/targets/fmu.h"
#include "codegen/targets/golden_replay.h"
#include "codegen/targets/library.h"
#include "codegen/targets/selftest.h"
#include "codegen/targets/single_header.h"

namespace nlo::codegen {
namespace {

/// Returns a target that writes one file, NAME with this ending.
ExportTarget one_file(const char* name, const char* description, const char* ending,
                      std::string (*text)(const PreparedExport&), bool of_c99 = false, bool no_observer = false) {
  const auto generate = [=](const PreparedExport& prepared) {
    return std::vector<NamedText>{{prepared.name() + ending, text(prepared)}};
  };
  return {name, description, ExportForm::kFile, generate, of_c99, false, no_observer};
}

}  // namespace

const std::vector<ExportTarget>& export_targets() {
  static const std::vector<ExportTarget> targets = {
      one_file("cpp", "C++20 header with the observer as a constant", ".h", cpp_header),
      one_file("replay", "C++20 header with inputs and the outputs that the cpp header must compute from them",
               "_replay.h", replay, false, true),
      {"c99", "C99 header and source with the observer; they need no C++ and no library", ExportForm::kFiles, c99,
       true},
      one_file("single", "C++20 header for audits: plain loops, no other header of nlo; computes the same bits as c99",
               ".h", single_header, true),
      one_file("replay-c99", "C99 header with inputs and the outputs that the c99 pair must compute from them",
               "_replay.h", replay_c99, true, true),
      {"selftest", "folder with the c99 pair and a program that replays inputs on your board and counts cycles",
       ExportForm::kDirectory, selftest, true},
      {"arduino", "folder with an Arduino and PlatformIO library: header, runtime, C99 pair, sketch",
       ExportForm::kDirectory, arduino_library},
      {"zephyr", "folder with a Zephyr module: header, runtime, C99 pair, sample", ExportForm::kDirectory,
       zephyr_module},
      {"fmu", "FMU for co-simulation by FMI 3.0: C99 sources and a binary, compiled by $CC or cc", ExportForm::kFile,
       fmu, true},
      {"fmu-sources", "FMU by FMI 3.0 without a binary, for importers that compile the sources", ExportForm::kFile,
       fmu_of_sources, true},
      {"fmu2", "FMU for co-simulation by FMI 2.0, for importers that do not read 3.0", ExportForm::kFile, fmu2, true},
      {"fmu2-sources", "FMU by FMI 2.0 without a binary", ExportForm::kFile, fmu2_of_sources, true},
      {"ros2_control",
       "folder with a ROS 2 package: header, runtime, a chainable controller that exports the estimates",
       ExportForm::kDirectory, ros2_control_package},
      {"simulink", "folder with a level-2 S-function around the C99 pair", ExportForm::kDirectory, simulink, true},
      {"px4", "folder with a module for PX4 around the C99 pair", ExportForm::kDirectory, px4_module, true},
      {"simplefoc", "folder with an Arduino library: a Sensor for SimpleFOC whose velocity is the estimate",
       ExportForm::kDirectory, simplefoc, true, true},
  };
  return targets;
}

const ExportTarget& export_target(const std::string& name) {
  std::string known;
  for (const ExportTarget& target : export_targets()) {
    if (target.name == name) return target;
    known += (known.empty() ? "" : ", ") + target.name;
  }
  throw Error("unknown export target \"" + name + "\"; there are " + known);
}

}  // namespace nlo::codegen
