// SPDX-License-Identifier: MIT
// The export that flew, on this machine: generated, compiled beside a small driver, and run over recorded readings. C99
// has the bits of the deterministic policy and of the single header on any processor; the C++ header those of
// the fast policy as this compiler and these flags make them.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "codegen/base/temporary.h"
#include "codegen/model/model.h"
#include "codegen/targets/observers_in.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::trainer {

/// As the options of nlo export, of which these decide the arithmetic.
struct Flown {
  std::string target = "c99", scalar = "float", weights = "float", max_error;
  std::string compiler;  ///< with its flags, blanks between; empty: cc -O1 or c++ -O2
};

/// One of an export's observers, as it is compiled here.
struct CompiledText {
  codegen::GeneratedObserver observer;
  std::string compiler;        ///< with its flags; empty: $CC or cc -O1, $CXX or c++ -O2
  bool deterministic = false;  ///< the C++ header's policy
};

class FlownExport {
 public:
  /// Compiles an existing export. `prepared` has the name of the observer.
  FlownExport(const codegen::PreparedExport& prepared, const CompiledText& text);

  /// Throws codegen::Error when the model has no such export, or nothing here compiles it.
  FlownExport(const codegen::Model& model, const Flown& flown);

  /// Runs the export from its start over `given` (flight_log.h). Returns a column for each call.
  Eigen::MatrixXd run(const Eigen::MatrixXd& given) const;

  bool single() const { return single_; }            ///< its numbers are floats
  bool settles() const { return settles_; }          ///< it has a steady state to start from
  const std::string& name() const { return name_; }  ///< "--target c99 --scalar float"

 private:
  FlownExport(const codegen::PreparedExport& prepared, const Flown& flown);

  std::unique_ptr<codegen::TemporaryFolder> folder_;
  Eigen::Index answers_;
  bool single_ = true, settles_ = false;
  std::string name_;
};

}  // namespace nlo::trainer
