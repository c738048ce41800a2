// SPDX-License-Identifier: MIT
// Zip archives. Equal files give equal archives.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/file.h"

namespace nlo::codegen {

/// Returns the check sum of zip and PNG, CRC-32 of IEEE 802.3.
std::uint32_t crc32(std::string_view bytes);

/// Returns an archive of `files` in their order, without compression, dated 1980-01-01, the first day of the format.
/// Throws Error beyond the limits of the format, 4 GiB and 65,535 files.
std::string zip(const std::vector<NamedText>& files);

/// Returns the files of such an archive. Throws Error if it is not an archive or a check sum is wrong.
std::vector<NamedText> unzipped(std::string_view archive);

}  // namespace nlo::codegen
