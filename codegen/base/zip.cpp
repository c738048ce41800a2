// SPDX-License-Identifier: MIT
#include "codegen/base/zip.h"

#include <array>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

constexpr std::uint64_t kMostBytes = 0xffffffffU, kMostFiles = 0xffff;

/// Little-endian, as all numbers of zip.
void put(std::string& bytes, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

/// What the header before a file and its entry in the directory at the end share.
std::string facts_of(const NamedText& file) {
  constexpr std::uint64_t kVersion = 20, kNamesAreUtf8 = 1U << 11, kStored = 0, kMidnight = 0, kFirstDay = 0x21;
  std::string bytes;
  for (const std::uint64_t value : {kVersion, kNamesAreUtf8, kStored, kMidnight, kFirstDay}) put(bytes, value, 2);
  for (const std::uint64_t value : {std::uint64_t{crc32(file.text)}, file.text.size(), file.text.size()})
    put(bytes, value, 4);
  put(bytes, file.path.size(), 2);
  put(bytes, 0, 2);  // no extra field
  return bytes;
}

}  // namespace

std::uint32_t crc32(std::string_view bytes) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      table[i] = i;
      for (int bit = 0; bit < 8; ++bit) table[i] = (table[i] >> 1) ^ ((table[i] & 1U) != 0 ? 0xedb88320U : 0U);
    }
    return table;
  }();
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) crc = (crc >> 8) ^ kTable[(crc ^ static_cast<unsigned char>(c)) & 0xffU];
  return ~crc;
}

std::string zip(const std::vector<NamedText>& files) {
  constexpr std::uint64_t kUnix = 3, kRegularFile = 0100644;  // as stat() has it
  std::string archive, directory;
  for (const NamedText& file : files) {
    const std::size_t offset = archive.size();
    const std::string facts = facts_of(file);
    archive += "PK\3\4" + facts + file.path + file.text;
    directory += "PK\1\2";
    put(directory, kUnix << 8 | 20, 2);
    directory += facts;
    put(directory, 0, 6);  // no comment, the first disk, no text attribute
    put(directory, kRegularFile << 16, 4);
    put(directory, offset, 4);
    directory += file.path;
  }
  const std::size_t begin = archive.size();
  if (begin + directory.size() > kMostBytes || files.size() > kMostFiles)
    throw Error("the archive would exceed what zip holds: 4 GiB, 65,535 files");
  archive += directory + "PK\5\6";
  put(archive, 0, 4);  // one disk
  for (int i = 0; i < 2; ++i) put(archive, files.size(), 2);
  put(archive, directory.size(), 4);
  put(archive, begin, 4);
  put(archive, 0, 2);  // no comment
  return archive;
}

}  // namespace nlo::codegen
