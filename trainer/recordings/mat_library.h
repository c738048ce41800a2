// SPDX-License-Identifier: MIT
// libmatio, loaded when a MAT-file is read. Included where its header is.
#pragma once

#include <matio.h>

#include <string>

#include "trainer/recordings/shared_library.h"

namespace nlo::trainer {

/// What is used of libmatio.
struct Matio {
  explicit Matio(const std::string& file) : library(NLO_MATIO, file) {}
  SharedLibrary library;
  decltype(&Mat_Close) close = library.find<decltype(Mat_Close)>("Mat_Close");
  decltype(&Mat_GetDir) directory = library.find<decltype(Mat_GetDir)>("Mat_GetDir");
  decltype(&Mat_LogInitFunc) log_to = library.find<decltype(Mat_LogInitFunc)>("Mat_LogInitFunc");
  decltype(&Mat_Open) open = library.find<decltype(Mat_Open)>("Mat_Open");
  decltype(&Mat_Rewind) rewind = library.find<decltype(Mat_Rewind)>("Mat_Rewind");
  decltype(&Mat_SizeOfClass) size_of = library.find<decltype(Mat_SizeOfClass)>("Mat_SizeOfClass");
  decltype(&Mat_VarFree) free = library.find<decltype(Mat_VarFree)>("Mat_VarFree");
  decltype(&Mat_VarGetNumberOfFields) fields =
      library.find<decltype(Mat_VarGetNumberOfFields)>("Mat_VarGetNumberOfFields");
  decltype(&Mat_VarGetStructFieldByName) field =
      library.find<decltype(Mat_VarGetStructFieldByName)>("Mat_VarGetStructFieldByName");
  decltype(&Mat_VarGetStructFieldnames) field_names =
      library.find<decltype(Mat_VarGetStructFieldnames)>("Mat_VarGetStructFieldnames");
  decltype(&Mat_VarRead) read = library.find<decltype(Mat_VarRead)>("Mat_VarRead");
  decltype(&Mat_VarReadNext) read_next = library.find<decltype(Mat_VarReadNext)>("Mat_VarReadNext");
};

inline const Matio& matio(const std::string& file = "") {
  static const Matio loaded(file);
  return loaded;
}

}  // namespace nlo::trainer
