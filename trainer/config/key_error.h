// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>

#include "codegen/base/error.h"

namespace nlo::trainer {

/// An error in an experiment and the key that causes it. The reader of the file adds FILE:LINE.
///   key   path: "plant.derivative", "log.columns[2]"; a section ("observer") if no single key is wrong
///   what  error and remedy; names the key in the form for readers: "[plant] derivative[1] ..."
class KeyError : public codegen::Error {
 public:
  KeyError(std::string key, const std::string& what) : codegen::Error(what), key_(std::move(key)) {}

  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace nlo::trainer
