// SPDX-License-Identifier: MIT
#include "codegen/base/directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/base/temporary.h"
#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Directory : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return base_.path(name); }

  /// Returns the message of check and write, which must be the same.
  std::string refusal(const std::string& name) const {
    std::string said = "none";
    try {
      check_directory(path(name));
    } catch (const Error& error) {
      said = error.what();
    }
    try {
      write_directory_atomically(path(name), {{"new.txt", "new"}});
      EXPECT_EQ(said, "none");
    } catch (const Error& error) {
      EXPECT_NE(said, "none") << error.what();
    }
    return said;
  }

  static std::string text_in(const Descriptor& folder, const char* file) {
    const Descriptor fd(::openat(folder.get(), file, O_RDONLY | O_CLOEXEC));
    char text[8];
    const ssize_t n = ::read(fd.get(), text, sizeof text);
    return n > 0 ? std::string(text, static_cast<std::size_t>(n)) : "";
  }

  /// Returns the number of entries beside the written folder; temporaries must be gone.
  std::ptrdiff_t beside() const {
    return std::distance(fs::directory_iterator(base_.path()), fs::directory_iterator());
  }

  ScratchDirectory base_;
};

TEST_F(Directory, HasItsFilesInTheirFolders) {
  write_directory_atomically(path("lib/"), {{"a.txt", "A"}, {"src/deep/b.txt", "B"}});
  EXPECT_EQ(read_file(path("lib/a.txt")), "A");
  EXPECT_EQ(read_file(path("lib/src/deep/b.txt")), "B");
  EXPECT_NE(fs::status(path("lib")).permissions(), fs::perms::owner_all) << "it still has the mode of mkdtemp";
  EXPECT_EQ(beside(), 1);
}

TEST_F(Directory, ReplacesItsOwnFolder) {
  write_directory_atomically(path("lib"), {{"old.txt", "old"}, {"src/b.txt", "B"}});
  fs::remove(path("lib/src/b.txt"));
  EXPECT_EQ(refusal("lib"), "none");
  EXPECT_FALSE(fs::exists(path("lib/old.txt")));
  EXPECT_EQ(read_file(path("lib/new.txt")), "new");
  EXPECT_EQ(beside(), 1);
}

TEST_F(Directory, KeepsFilesThatOthersMadeOrChanged) {
  fs::create_directory(path("theirs"));
  write_file_atomically(path("theirs/thesis.tex"), "years of work");
  EXPECT_THAT(refusal("theirs"), HasSubstr("not made by nlo"));

  write_directory_atomically(path("added"), {{"a.txt", "A"}});
  write_file_atomically(path("added/notes.txt"), "notes");
  EXPECT_THAT(refusal("added"), HasSubstr("added/notes.txt: was added or changed"));

  write_directory_atomically(path("changed"), {{"a.txt", "A"}});
  write_file_atomically(path("changed/a.txt"), "AA");
  EXPECT_THAT(refusal("changed"), HasSubstr("changed/a.txt: was added or changed"));
  EXPECT_EQ(read_file(path("changed/a.txt")), "AA");

  write_file_atomically(path("file"), "text");
  EXPECT_THAT(refusal("file"), HasSubstr("is not a folder"));
  EXPECT_THAT(refusal("file/below"), HasSubstr("file is not a folder"));
  fs::create_directory_symlink("nowhere", path("link"));
  EXPECT_THAT(refusal("link"), HasSubstr("is a link to a folder that does not exist"));
  EXPECT_EQ(beside(), 5);
}

/// Regression test: a reader in a loop found no folder in 3 of 100 attempts.
TEST_F(Directory, IsCompleteAtAnyTimeWhileTwoWritersReplaceIt) {
  const std::vector<NamedText> first = {{"a.txt", "1"}, {"src/b.txt", "1"}},
                               second = {{"a.txt", "2"}, {"src/b.txt", "2"}};
  write_directory_atomically(path("lib"), first);
  std::atomic<bool> writing{true};
  long looks = 0, misses = 0, mixed = 0;
  std::thread reader([&] {
    while (writing) {
      // Reads through one descriptor, as a build in its working folder does: all files must come from one export.
      const Descriptor folder(::open(path("lib").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
      ++looks;
      if (folder.get() < 0) ++misses;
      const std::string a = text_in(folder, "a.txt"), b = text_in(folder, "src/b.txt");
      mixed += !a.empty() && !b.empty() && a != b;  // an old folder that is being removed no longer has both files
    }
  });
  const auto write = [&](const std::vector<NamedText>& files) {
    for (int i = 0; i < 40; ++i) write_directory_atomically(path("lib"), files);
  };
  std::thread other(write, second);
  write(first);
  other.join();
  writing = false;
  reader.join();
  EXPECT_GT(looks, 100);
  EXPECT_EQ(misses, 0) << "of " << looks;
  EXPECT_EQ(mixed, 0) << "of " << looks;
  EXPECT_EQ(beside(), 1) << "a writer left a temporary folder";
}

TEST_F(Directory, RemovesOnlyTemporariesOfKilledExports) {
  fs::create_directories(path("lib.nlo-ab12CD/src"));
  write_file_atomically(path("lib.nlo-ab12CD/src/half.c"), "int ha");
  fs::create_directory(path("lib.nlo-inuse1"));
  const Descriptor in_use = hold(path("lib.nlo-inuse1"));
  fs::create_directory(path("lib.nlo-mine"));
  fs::create_directory(path("libs.nlo-ab12CD"));
  write_directory_atomically(path("lib"), {{"a.txt", "A"}});
  EXPECT_FALSE(fs::exists(path("lib.nlo-ab12CD")));
  EXPECT_TRUE(fs::exists(path("lib.nlo-inuse1"))) << "another program is writing it";
  EXPECT_TRUE(fs::exists(path("lib.nlo-mine"))) << "its name is not that of a temporary";
  EXPECT_TRUE(fs::exists(path("libs.nlo-ab12CD"))) << "it belongs to another export";
}

TEST_F(Directory, AnEmptyFolderMayBeReplaced) {
  fs::create_directory(path("empty"));
  EXPECT_EQ(refusal("empty"), "none");
  for (const char* name : {"", ".", "..", "/"}) EXPECT_THROW(check_directory(name), Error) << name;
}

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

TEST_F(File, ReadsBackTheBytesThatItWrote) {
  const std::string bytes("a\0b\r\n", 5);
  write_file_atomically(path("x"), bytes);
  EXPECT_EQ(read_file(path("x")), bytes);
  EXPECT_EQ(files(), 1);
}

TEST_F(File, NewFilesFollowTheUmaskAndOldOnesKeepTheirMode) {
  write_file_atomically(path("x"), "1");
  struct stat found {};
  ASSERT_EQ(::stat(path("x").c_str(), &found), 0);
  EXPECT_NE(found.st_mode & S_IRUSR, 0U);
  EXPECT_NE(found.st_mode & 0777U, 0600U) << "it still has the mode of mkstemp";
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

TEST_F(File, WritesThroughALinkToAMissingFile) {
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

/// Regression test: 187 kills had left 74 temporary files.
TEST_F(File, TheNextWriteRemovesTemporariesOfAKilledProgram) {
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

TEST_F(File, IsRewrittenOnlyIfUnchangedSinceItWasRead) {
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

TEST_F(File, SeveralFilesAreReplacedTogetherOrNotAtAll) {
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
