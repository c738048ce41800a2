// SPDX-License-Identifier: MIT
// Reads and writes whole files. Writing is atomic: after a crash or with a full disk there is the old file or the new
// one, never a part. Errors name the path and the reason of the system.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::codegen {

/// Returns the bytes of `path`. Throws Error when it cannot be read, is a directory, or holds more than `max_bytes`.
std::string read_file(const std::string& path, std::size_t max_bytes = std::size_t{1} << 30);

/// Replaces the contents of `path` by `text`: writes a temporary file beside it, syncs and renames it. Follows links,
/// also to a file that does not exist yet. Writes directly to a path that is no regular file (/dev/stdout, a pipe). On
/// an Error the file is unchanged.
void write_file_atomically(const std::string& path, std::string_view text);

/// Writes like write_file_atomically() over a file whose contents were `read`. Throws Error if the contents have
/// changed since, so that a change by somebody else is not lost.
void rewrite_file_atomically(const std::string& path, std::string_view read, std::string_view text);

/// A file to write.
struct NamedText {
  std::string path, text;
};

/// Replaces all `files` (regular or new files) or none. It renames the first only when all are on disk. If a rename
/// fails, it restores the earlier ones. A crash between two renames leaves old and new files, each of them complete.
/// Throws Error.
void write_files_atomically(const std::vector<NamedText>& files);

/// Syncs the folder of `path`: a renamed file is on disk only when its folder is. Ignores file systems that cannot sync
/// folders.
void sync_folder_of(const std::string& path);

}  // namespace nlo::codegen
