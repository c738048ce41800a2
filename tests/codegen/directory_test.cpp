// SPDX-License-Identifier: MIT
#include "codegen/base/directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/file.h"

namespace nlo::codegen {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Directory : public testing::Test {
 protected:
  Directory() : base_(fs::temp_directory_path() / ("nlo_directory_test_" + std::to_string(::getpid()))) {
    fs::create_directory(base_);
  }
  ~Directory() override { fs::remove_all(base_); }
  std::string path(const std::string& name) const { return (base_ / name).string(); }

  /// What check and write have to say, the same of both.
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

  /// Nothing temporary is left beside what was written.
  std::ptrdiff_t beside() const { return std::distance(fs::directory_iterator(base_), fs::directory_iterator()); }

  fs::path base_;
};

TEST_F(Directory, HasItsFilesInTheirFolders) {
  write_directory_atomically(path("lib/"), {{"a.txt", "A"}, {"src/deep/b.txt", "B"}});
  EXPECT_EQ(read_file(path("lib/a.txt")), "A");
  EXPECT_EQ(read_file(path("lib/src/deep/b.txt")), "B");
  EXPECT_NE(fs::status(path("lib")).permissions(), fs::perms::owner_all) << "the mode of mkdtemp has stayed";
  EXPECT_EQ(beside(), 1);
}

TEST_F(Directory, ReplacesWhatItHasMade) {
  write_directory_atomically(path("lib"), {{"old.txt", "old"}, {"src/b.txt", "B"}});
  fs::remove(path("lib/src/b.txt"));
  EXPECT_EQ(refusal("lib"), "none");
  EXPECT_FALSE(fs::exists(path("lib/old.txt")));
  EXPECT_EQ(read_file(path("lib/new.txt")), "new");
  EXPECT_EQ(beside(), 1);
}

TEST_F(Directory, KeepsWhatSomebodyHasMadeOrChanged) {
  fs::create_directory(path("theirs"));
  write_file_atomically(path("theirs/thesis.tex"), "years of work");
  EXPECT_THAT(refusal("theirs"), HasSubstr("not made by nlo export"));

  write_directory_atomically(path("added"), {{"a.txt", "A"}});
  write_file_atomically(path("added/notes.txt"), "notes");
  EXPECT_THAT(refusal("added"), HasSubstr("added/notes.txt: was added or changed"));

  write_directory_atomically(path("changed"), {{"a.txt", "A"}});
  write_file_atomically(path("changed/a.txt"), "AA");
  EXPECT_THAT(refusal("changed"), HasSubstr("changed/a.txt: was added or changed"));
  EXPECT_EQ(read_file(path("changed/a.txt")), "AA");

  write_file_atomically(path("file"), "text");
  EXPECT_THAT(refusal("file"), HasSubstr("is no folder"));
  EXPECT_THAT(refusal("no/such"), HasSubstr("make it first"));
  EXPECT_EQ(beside(), 4);
}

TEST_F(Directory, AnEmptyOneIsFree) {
  fs::create_directory(path("empty"));
  EXPECT_EQ(refusal("empty"), "none");
  for (const char* name : {"", ".", "..", "/"}) EXPECT_THROW(check_directory(name), Error) << name;
}

}  // namespace
}  // namespace nlo::codegen
