#include "tools/user_paths.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <stdexcept>

#include "support/error_of.h"
#include "support/scratch_folder.h"
#include "tools/tool_arguments.h"

namespace tactile_clay::tools::user_paths_test {
namespace {

namespace fs = std::filesystem;

std::string pathError(const std::string& name) {
  return errorOf([&] { userPath(name, "scene", "/here", "/home/me"); });
}

TEST(UserPath, IsNamedFromTheWorkingDirectoryOrTheHomeFolder) {
  const auto path = [](const std::string& name) {
    return userPath(name, "scene", "/here it's $(5)", "/home/me");
  };
  EXPECT_EQ(path("mine.yaml"), "/here it's $(5)/mine.yaml");
  EXPECT_EQ(path("./mine.yaml"), "/here it's $(5)/./mine.yaml");
  EXPECT_EQ(path("~/mine.yaml"), "/home/me/mine.yaml");
  EXPECT_EQ(path("/a/~/b \"c\"; &d"), "/a/~/b \"c\"; &d");
  EXPECT_EQ(path("./~x"), "/here it's $(5)/./~x");
  EXPECT_EQ(path("Händel.yaml"), "/here it's $(5)/Händel.yaml");
  EXPECT_EQ(path(""), "");
}

TEST(UserPath, WhatRosCannotHandOnIsRefused) {
  EXPECT_NE(pathError("~anna/mine.yaml").find("scene '~anna/mine.yaml': expected ~/"), std::string::npos);
  EXPECT_NE(pathError("H\xE4ndel").find("not UTF-8"), std::string::npos);  // Latin-1
  EXPECT_NE(pathError("cut \xC3").find("not UTF-8"), std::string::npos);
  EXPECT_NE(pathError("long \xC0\xAF").find("not UTF-8"), std::string::npos);      // a slash in two bytes
  EXPECT_NE(pathError("half \xED\xA0\x80").find("not UTF-8"), std::string::npos);  // of a surrogate pair
  EXPECT_NE(pathError("bell \x07").find("control character"), std::string::npos);
  EXPECT_NE(errorOf([] { userPath("~/x", "file", "/here", ""); }).find("HOME"), std::string::npos);
}

TEST(ArgumentLines, AreTakenApartButNoValueGoesOverTwo) {
  EXPECT_EQ(argumentLines("scene:=a b"), (std::vector<std::string>{"scene:=a b"}));
  EXPECT_EQ(argumentLines("scene:=a\nfile:=b"), (std::vector<std::string>{"scene:=a", "file:=b"}));
  EXPECT_EQ(argumentLines("scene:=\nfile:="), (std::vector<std::string>{"scene:=", "file:="}));
  EXPECT_NE(errorOf([] { argumentLines("scene:=a\nb"); }).find("without line breaks"), std::string::npos);
}

class NewBag : public ScratchFolder {
 protected:
  std::string refused(const std::string& name) const {
    return errorOf([&] { requireNewBag((folder / name).string()); });
  }
};

TEST_F(NewBag, EndsWithBagAndItsFolderMayBeMissing) {
  EXPECT_EQ(requireNewBag((folder / "run").string()), (folder / "run.bag").string());
  EXPECT_EQ(requireNewBag((folder / "run.bag").string()), (folder / "run.bag").string());
  EXPECT_EQ(requireNewBag((folder / "not/there/run.bag").string()), (folder / "not/there/run.bag").string());
}

TEST_F(NewBag, ReplacesNothing) {
  write("old.bag", "x");
  write("busy.bag.active", "x");
  fs::create_symlink("nowhere", folder / "link.bag");
  EXPECT_NE(refused("old.bag").find("exists already"), std::string::npos);
  EXPECT_NE(refused("old").find("old.bag' exists already"), std::string::npos);
  EXPECT_NE(refused("busy").find("rosbag reindex"), std::string::npos);
  EXPECT_NE(refused("link.bag").find("exists already"), std::string::npos);
}

TEST_F(NewBag, NothingIsLeftOfTheTry) {
  requireNewBag((folder / "run").string());
  requireNewBag((folder / "not/there/run").string());
  requireFolderToWrite(folder.string());
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(NewBag, NamesThatNoFileCanHaveAreRefused) {
  const std::string whole = ".bag.active";
  const std::string longest(255 - whole.size(), 'n'), folder_name(256, 'f');  // bytes, of most file systems
  EXPECT_EQ(requireNewBag((folder / longest).string()), (folder / (longest + ".bag")).string());
  for (const std::string& name :
       {longest + "n", folder_name + "/run", "not/there/" + longest + "n", "not/" + folder_name + "/run"}) {
    const std::string line = refused(name);
    EXPECT_NE(line.find("record '" + (folder / name).string() + "': '"), std::string::npos) << line;
    EXPECT_NE(line.find("ame too long"), std::string::npos) << line;
  }
}

// Nobody can make a file there, not even root.
TEST_F(NewBag, AFolderThatTakesNoFileIsRefused) {
  for (const char* name : {"/proc/run", "/proc/not/there/run"})
    EXPECT_NE(errorOf([&] { requireNewBag(name); }).find("nothing can be made in folder '/proc': "),
              std::string::npos)
        << name;
  EXPECT_NE(errorOf([] { requireFolderToWrite("/proc"); }).find("folder '/proc'"), std::string::npos);
}

TEST_F(NewBag, WhatCannotBeMadeIsRefusedWithItsFolder) {
  write("file", "x");
  EXPECT_NE(refused("file/run.bag").find((folder / "file").string() + "' is not a folder"),
            std::string::npos);
  EXPECT_NE(refused("").find("is a folder"), std::string::npos);
  if (::geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  fs::create_directory(folder / "locked");
  fs::permissions(folder / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_NE(refused("locked/run.bag").find("locked': Permission denied"), std::string::npos);
}

// A link or a topic may have such a name.
TEST(Tool, PrintsItsErrorAsOneLine) {
  char name[] = "tool";
  char* arguments[] = {name, nullptr};
  testing::internal::CaptureStderr();
  EXPECT_EQ(runTool("tool", "", 1, arguments, [] { throw std::runtime_error("link 'a\n\x1B[2Jb'"); }), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "tool: link 'a??[2Jb'\n");
}

}  // namespace
}  // namespace tactile_clay::tools::user_paths_test
