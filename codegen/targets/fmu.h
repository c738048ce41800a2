// SPDX-License-Identifier: MIT
// Writes an FMU for co-simulation by FMI 3.0 or 2.0: a zip archive of the description that importers read
// (modelDescription.xml), the C99 pair with the functions of the standard, and a shared library of both. Each file
// comes from templates/fmu and templates/fmu2.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns NAME.fmu with sources only, for importers that compile them, with the same bytes for the same model. Throws
/// Error if c99() does.
std::vector<NamedText> fmu_of_sources(const PreparedExport& prepared);

/// Returns NAME.fmu with a shared library, too. The C compiler of this machine ($CC, or cc) makes it for Linux on the
/// compiler's processor. Throws Error with the output of the compiler if this fails.
std::vector<NamedText> fmu(const PreparedExport& prepared);

/// The same two exports by FMI 2.0, which has no arrays: z and initial_z are scalars z[1], z[2] and so on.
std::vector<NamedText> fmu2_of_sources(const PreparedExport& prepared);
std::vector<NamedText> fmu2(const PreparedExport& prepared);

}  // namespace nlo::codegen
