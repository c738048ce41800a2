// SPDX-License-Identifier: MIT
// A library that is loaded when it is first needed: who has no such recordings needs none of them.
#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include <string>

#include "codegen/base/error.h"

namespace nlo::trainer {

class SharedLibrary {
 public:
  /// Loaded for good. Throws codegen::Error, which names `file`, whose reader wants it, where this machine has none.
  SharedLibrary(const char* name, const std::string& file) : handle_(dlopen(name, RTLD_NOW | RTLD_LOCAL)), name_(name) {
    if (handle_ == nullptr)
      throw codegen::Error(fmt::format("{}: {} reads such files, and is not here: install it", file, name));
  }

  /// `Function`: the type of a function as its header declares it.
  template <class Function>
  Function* find(const char* function) const {
    void* const address = dlsym(handle_, function);
    if (address == nullptr)
      throw codegen::Error(fmt::format("{} has no {}: install the version that nlo was built with", name_, function));
    return reinterpret_cast<Function*>(address);
  }

 private:
  void* handle_;
  const char* name_;
};

}  // namespace nlo::trainer
