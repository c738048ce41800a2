// SPDX-License-Identifier: MIT
#include "codegen/base/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "codegen/base/temporary.h"
#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class File : public testing::Test {
 protected:
  std::string path(const char* name) const { return folder_.path(name); }
  std::ptrdiff_t files() const {
    return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
  }

  ScratchDirectory folder_;
};

TEST_F(File, ReadsWhatWasWritten) {
  const std::string bytes("a\0b\r\n", 5);
  write_file_atomically(path("x"), bytes);
  EXPECT_EQ(read_file(path("x")), bytes);
  EXPECT_EQ(files(), 1);
}

TEST_F(File, NewFilesObeyTheUmaskAndOldOnesKeepTheirMode) {
  write_file_atomically(path("x"), "1");
  struct stat found {};
  ASSERT_EQ(::stat(path("x").c_str(), &found), 0);
  EXPECT_NE(found.st_mode & S_IRUSR, 0U);
  EXPECT_NE(found.st_mode & 0777U, 0600U) << "the mode of mkstemp has stayed";
  ASSERT_EQ(::chmod(path("x").c_str(), 0640), 0);
  write_file_atomically(path("x"), "2");
  ASSERT_EQ(::stat(path("x").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777U, 0640U);
}

TEST_F(File, WritesThroughALink) {
  write_file_atomically(path("x"), "old");
  fs::create_symlink(path("x"), path("link"));
  write_file_atomically(path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_file(path("x")), "new");
}

TEST_F(File, WritesThroughALinkToAFileThatIsNotThereYet) {
  fs::create_directory(path("d"));
  fs::create_symlink("later", path("d/second"));
  fs::create_symlink("d/second", path("first"));
  write_file_atomically(path("first"), "one");
  EXPECT_TRUE(fs::is_symlink(path("first")));
  EXPECT_TRUE(fs::is_symlink(path("d/second")));
  EXPECT_EQ(read_file(path("d/later")), "one");
  write_files_atomically({{path("first"), "two"}});
  EXPECT_EQ(read_file(path("d/later")), "two");

  fs::create_symlink("no/such/folder", path("broken"));
  EXPECT_THAT(thrown_message([&] { write_file_atomically(path("broken"), "x"); }), HasSubstr("No such file"));
  fs::create_symlink("round", path("round"));
  EXPECT_THAT(thrown_message([&] { write_file_atomically(path("round"), "x"); }), HasSubstr("symbolic links"));
  EXPECT_EQ(files(), 4);
}

/// 187 kills had left 74 of them.
TEST_F(File, WhatAKilledProgramHasLeftGoesWithTheNextWriting) {
  write_file_atomically(path("x"), "1");
  std::ofstream(path("x.nlo-ab12CD")) << "ha";
  std::ofstream(path("x.nlo-inuse1")) << "ha";
  const Descriptor in_use = hold(path("x.nlo-inuse1"));
  std::ofstream(path("y.nlo-ab12CD")) << "ha";
  write_file_atomically(path("x"), "2");
  EXPECT_FALSE(fs::exists(path("x.nlo-ab12CD")));
  EXPECT_TRUE(fs::exists(path("x.nlo-inuse1")));
  EXPECT_TRUE(fs::exists(path("y.nlo-ab12CD")));
  EXPECT_EQ(read_file(path("x")), "2");
}

TEST_F(File, IsRewrittenOnlyAsLongAsItIsWhatWasRead) {
  write_file_atomically(path("x"), "read");
  rewrite_file_atomically(path("x"), "read", "rewritten");
  EXPECT_EQ(read_file(path("x")), "rewritten");
  write_file_atomically(path("x"), "somebody else's");
  EXPECT_THAT(thrown_message([&] { rewrite_file_atomically(path("x"), "rewritten", "lost"); }),
              HasSubstr("has changed since"));
  EXPECT_EQ(read_file(path("x")), "somebody else's");
  fs::remove(path("x"));
  EXPECT_THAT(thrown_message([&] { rewrite_file_atomically(path("x"), "rewritten", "lost"); }),
              HasSubstr("x: cannot open"));
  EXPECT_FALSE(fs::exists(path("x")));
}

TEST_F(File, LeavesDevicesInPlace) {
  write_file_atomically("/dev/null", "text");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(File, SeveralAreReplacedTogetherOrNotAtAll) {
  write_files_atomically({{path("x"), "1"}, {path("y"), "2"}});
  EXPECT_EQ(read_file(path("x")) + read_file(path("y")), "12");
  write_files_atomically({{path("x"), "3"}, {path("y"), "4"}});
  EXPECT_EQ(read_file(path("x")) + read_file(path("y")), "34");
  for (const std::string& bad : {path("no/y"), folder_.path(), std::string("/dev/null")}) {
    EXPECT_NE(thrown_message([&] { write_files_atomically({{path("x"), "5"}, {bad, "6"}}); }), "no error");
    EXPECT_EQ(read_file(path("x")), "3") << bad;
  }
  EXPECT_EQ(files(), 2);
}

TEST_F(File, ErrorsNameThePathAndTheReason) {
  EXPECT_THAT(thrown_message([&] { read_file(path("none")); }),
              testing::AllOf(HasSubstr(path("none")), HasSubstr("No such file")));
  EXPECT_THAT(thrown_message([&] { read_file(folder_.path()); }), HasSubstr("Is a directory"));
  EXPECT_THAT(thrown_message([&] { write_file_atomically(folder_.path(), "x"); }), HasSubstr("Is a directory"));
  EXPECT_THAT(thrown_message([&] { write_file_atomically(path("no/x"), "x"); }), HasSubstr("No such file"));
  EXPECT_THAT(thrown_message([&] { read_file("/dev/zero", 1000); }), HasSubstr("larger than the 1000 bytes"));
  EXPECT_EQ(files(), 0);
}

}  // namespace
}  // namespace nlo::codegen
