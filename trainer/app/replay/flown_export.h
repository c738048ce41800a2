// SPDX-License-Identifier: MIT
// The exported code of a flight on this machine: generated, compiled with a small driver, and run over recorded
// readings. C99 has the bits of the deterministic policy and of the single header on any processor. The C++ header has
// the bits of the fast policy with this compiler and these flags.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "codegen/base/temporary.h"
#include "codegen/model/model.h"
#include "codegen/targets/observers_in.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::trainer {

/// The options of nlo export that determine the arithmetic.
struct Flown {
  std::string target = "c99", scalar = "float", weights = "float", max_error;
  std::string compiler;  ///< with its flags, separated by blanks; empty: cc -O1 or c++ -O2
};

/// An observer of an export, and how it is compiled here.
struct CompiledText {
  codegen::GeneratedObserver observer;
  std::string compiler;        ///< with its flags; empty: $CC or cc -O1, $CXX or c++ -O2
  bool deterministic = false;  ///< the C++ header's policy
};

class FlownExport {
 public:
  /// Compiles an existing export. `prepared` has the name of the observer.
  FlownExport(const codegen::PreparedExport& prepared, const CompiledText& text);

  /// Generates and compiles the export. Throws codegen::Error if the model has no such export, or if nothing here
  /// compiles it.
  FlownExport(const codegen::Model& model, const Flown& flown);

  /// Runs the export from its start over `given` (flight_log.h). Returns a column for each call.
  Eigen::MatrixXd run(const Eigen::MatrixXd& given) const;

  bool single() const { return single_; }            ///< true if its numbers are floats
  bool settles() const { return settles_; }          ///< true if it has a steady state for its start
  const std::string& name() const { return name_; }  ///< "--target c99 --scalar float"

 private:
  FlownExport(const codegen::PreparedExport& prepared, const Flown& flown);

  std::unique_ptr<codegen::TemporaryFolder> folder_;
  Eigen::Index answers_;
  bool single_ = true, settles_ = false;
  std::string name_;
};

}  // namespace nlo::trainer
