// SPDX-License-Identifier: MIT
#include "codegen/base/zip.h"

#include <array>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

constexpr std::uint64_t kMostBytes = 0xffffffffU, kMostFiles = 0xffff;

/// Appends a number in little-endian order, as zip needs it.
void put(std::string& bytes, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

/// Returns the fields that the header of a file and its directory entry share.
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
  constexpr std::uint64_t kUnix = 3, kRegularFile = 0100644;  // mode of stat()
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

std::vector<NamedText> unzipped(std::string_view archive) {
  constexpr std::size_t kHeader = 30, kMethod = 8, kSum = 14, kSize = 18, kNameSize = 26, kMoreSize = 28;
  std::vector<NamedText> files;
  std::size_t at = 0;
  const auto number = [&](std::size_t place, std::size_t count) {
    std::size_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(archive[at + place + i]);
    return value;
  };
  while (archive.substr(at, 4) == "PK\3\4" && archive.size() - at > kHeader) {
    const std::size_t name = number(kNameSize, 2), text = kHeader + name + number(kMoreSize, 2);
    NamedText file{std::string(archive.substr(at + kHeader, name)), ""};
    if (number(kMethod, 2) != 0 || archive.size() - at < text + number(kSize, 4))
      throw Error(file.path + ": the archive ends too early, or is compressed");
    file.text = archive.substr(at + text, number(kSize, 4));
    if (crc32(file.text) != number(kSum, 4))
      throw Error(file.path + ": its checksum differs from the one in the archive; the archive is damaged");
    at += text + file.text.size();
    files.push_back(std::move(file));
  }
  if (archive.substr(at, 4) != "PK\1\2") throw Error("the file is not a zip archive without compression");
  return files;
}

}  // namespace nlo::codegen
