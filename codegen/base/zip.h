// SPDX-License-Identifier: MIT
// Zip archives: the same bytes for the same files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/file.h"

namespace nlo::codegen {

/// The check sum of zip and PNG: CRC-32 of IEEE 802.3.
std::uint32_t crc32(std::string_view bytes);

/// `files` in their order, stored without compression, dated 1980-01-01, the first day that zip knows: any unzip reads
/// it. Throws Error when the archive is larger than the 4 GiB, or has more than the 65,535 files, that plain zip holds.
std::string zip(const std::vector<NamedText>& files);

/// The files of such an archive. Throws Error when it is none, or a check sum is another.
std::vector<NamedText> unzipped(std::string_view archive);

}  // namespace nlo::codegen
