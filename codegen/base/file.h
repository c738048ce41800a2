// SPDX-License-Identifier: MIT
// Whole files as text. Writing is atomic: a reader, a crash or a full disk sees the old file or the new one, never half
// of either. Errors name the path and the system's reason.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::codegen {

/// The bytes of `path`. Throws Error when it cannot be read, is a directory, or holds more than `max_bytes`.
std::string read_file(const std::string& path, std::size_t max_bytes = std::size_t{1} << 30);

/// Replaces `path` by `text`: a temporary file beside it, fsync, rename. Links are followed, also to a file
/// that is not there yet; what is no regular file (/dev/stdout, a pipe) is written to directly. Throws Error, and then
/// `path` is what it was before.
void write_file_atomically(const std::string& path, std::string_view text);

/// The same for a file that was read as `read` and is rewritten from that. Throws Error where it is another one by now:
/// what somebody else has put there is not lost.
void rewrite_file_atomically(const std::string& path, std::string_view read, std::string_view text);

/// A file that is still to be written.
struct NamedText {
  std::string path, text;
};

/// Replaces all of `files` (regular ones, or new) or none: the first is renamed into place only when all are on disk,
/// and when a rename fails those before it are put back. A crash between two renames leaves some old and some new, each
/// whole. Throws Error.
void write_files_atomically(const std::vector<NamedText>& files);

/// What was renamed to `path` is on disk only when its folder is; a file system that cannot sync folders is let be.
void sync_folder_of(const std::string& path);

}  // namespace nlo::codegen
