// SPDX-License-Identifier: MIT
// An FMU for co-simulation by FMI 3.0 or 2.0: a zip of the description that importers read (modelDescription.xml),
// the C99 pair with the standard's functions around it, and a shared library of both. Each file comes from
// templates/fmu and templates/fmu2.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// NAME.fmu with the sources alone, for importers that compile: the same bytes for the same model. Throws Error when
/// c99() does.
std::vector<NamedText> fmu_of_sources(const PreparedExport& prepared);

/// NAME.fmu with a shared library too, by the C compiler of this machine ($CC, or cc), for Linux on the compiler's
/// processor. Throws Error with the compiler's output if there is no library.
std::vector<NamedText> fmu(const PreparedExport& prepared);

/// The two exports by FMI 2.0, which has no arrays: z and initial_z are scalars z[1], z[2] and so on.
std::vector<NamedText> fmu2_of_sources(const PreparedExport& prepared);
std::vector<NamedText> fmu2(const PreparedExport& prepared);

}  // namespace nlo::codegen
