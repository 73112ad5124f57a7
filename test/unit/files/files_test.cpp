#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <zlib.h>

#include <csignal>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "files/input_file.h"
#include "files/output_file.h"
#include "support/error_of.h"
#include "support/scratch_folder.h"

namespace tactile_clay::files::files_test {
namespace {

class Files : public ScratchFolder {
 protected:
  std::string path(const std::string& name) const { return (folder / name).string(); }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      all.push_back(entry.path().filename().string());
    return all;
  }

  std::string packed(const std::string& name, const std::string& text) const {
    gzFile file = gzopen(path(name).c_str(), "wb");
    EXPECT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
    gzclose(file);
    return path(name);
  }

  /// A socket bound to a name of the folder, which is short enough for one.
  std::string socketFile() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path("socket").c_str(), sizeof address.sun_path - 1);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(fd);
    return path("socket");
  }
};

TEST_F(Files, AreReadWhole) {
  std::string text(300'000, 'x');
  text[70'000] = '\0';
  EXPECT_EQ(readWhole(write("text", text), 300'000), text);
  EXPECT_EQ(readUnpacked(path("text"), 300'000), text);
  EXPECT_EQ(readUnpacked(packed("text.gz", text), 300'000), text);
}

TEST_F(Files, OfAnotherBeginningAreNotRead) {
  const std::string text(300'000, 'x');
  EXPECT_EQ(readWholeWith("xxx", write("text", text), 300'000), text);
  EXPECT_EQ(readWholeWith("xxy", path("text"), 300'000), std::nullopt);
  EXPECT_EQ(readWholeWith("short", write("short", "sho"), 300'000), std::nullopt);
}

/// One line each, at once, that names the file, what it is, and what was expected.
TEST_F(Files, OnlyRegularOnesAreRead) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  const std::vector<std::pair<std::string, std::string>> cases = {
      {path("fifo"), "is a FIFO"},
      {path(""), "is a folder"},
      {"/dev/zero", "is a device"},
      {socketFile(), "is a socket"},
      {write("empty", ""), "is empty"},
      {path("nowhere"), "No such file"},
      {write("long", "12345678"), "has 8 bytes, expected at most 7"},
      {"", "No such file"},
      {"/proc/self/status", "is empty"},
      {path("nowhere/at/all"), "No such file"}};
  for (const auto& [file, words] : cases)
    for (const auto& line :
         {errorOf([&, f = file] { readWhole(f, 7); }), errorOf([&, f = file] { readUnpacked(f, 7); }),
          errorOf([&, f = file] { requireInput(f, 7); })}) {
      EXPECT_EQ(line.rfind(file + ": ", 0), 0u) << line;
      EXPECT_NE(line.find(words), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
}

TEST_F(Files, ABombIsNotUnpacked) {
  const std::string bomb = packed("bomb.gz", std::string(4 * mebibyte, '\n'));
  ASSERT_LT(std::filesystem::file_size(bomb), 8192u);
  EXPECT_NE(errorOf([&] { readUnpacked(bomb, mebibyte); }).find("unpacks to more than 1048576 bytes"),
            std::string::npos);
  std::filesystem::resize_file(bomb, std::filesystem::file_size(bomb) - 9);
  EXPECT_NE(errorOf([&] { readUnpacked(bomb, 8 * mebibyte); }).find("cannot be unpacked"), std::string::npos);
}

TEST_F(Files, AreWrittenWhole) {
  writeWhole(path("new"), "first", Existing::keep);
  EXPECT_EQ(readWhole(path("new"), 100), "first");
  EXPECT_EQ(names(), std::vector<std::string>{"new"});
}

TEST_F(Files, NothingIsReplacedUnasked) {
  write("old", "precious");
  const std::string line = errorOf([&] { writeWhole(path("old"), "other", Existing::keep); });
  EXPECT_NE(line.find("old: exists already"), std::string::npos) << line;
  EXPECT_EQ(readWhole(path("old"), 100), "precious");
  ASSERT_EQ(::chmod(path("old").c_str(), 0640), 0);
  writeWhole(path("old"), "other", Existing::replace);
  EXPECT_EQ(readWhole(path("old"), 100), "other");
  struct stat status {};
  ASSERT_EQ(::stat(path("old").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640u);
  EXPECT_EQ(names(), std::vector<std::string>{"old"});
}

/// Neither a device nor the target of a link: both stay as they are.
TEST_F(Files, OnlyRegularOnesAreReplaced) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  std::filesystem::create_directory(path("sub"));
  std::filesystem::create_symlink("/dev/null", path("link"));
  std::filesystem::create_symlink("nowhere", path("loose"));
  const auto before = names();
  for (const std::string& file :
       {path("fifo"), path("sub"), path("link"), path("loose"), std::string("/dev/null"), path("no/folder"),
        std::string(), write("file", "x") + "/below"}) {
    const std::string line = errorOf([&] { writeWhole(file, "text", Existing::replace); });
    EXPECT_NE(line.find("expected"), std::string::npos) << file << ": " << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    std::filesystem::remove(path("file"));
    EXPECT_EQ(names(), before);
  }
  struct stat status {};
  ASSERT_EQ(::stat("/dev/null", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

TEST_F(Files, ALinkIsFollowed) {
  write("old", "precious");
  std::filesystem::create_symlink("old", path("link"));
  writeWhole(path("link"), "other", Existing::replace);
  EXPECT_EQ(readWhole(path("old"), 100), "other");
  EXPECT_TRUE(std::filesystem::is_symlink(path("link")));
}

/// A disk that is full: what was there stays, and nothing new is left.
TEST_F(Files, AFullDiskLeavesWhatWasThere) {
  write("old", "precious");
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &usual), 0);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  rlimit small = usual;
  small.rlim_cur = 1000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string line =
      errorOf([&] { writeWhole(path("old"), std::string(5000, 'x'), Existing::replace); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &usual), 0);
  ::signal(SIGXFSZ, handler);
  EXPECT_NE(line.find("cannot be written"), std::string::npos) << line;
  EXPECT_EQ(readWhole(path("old"), 100), "precious");
  EXPECT_EQ(names(), std::vector<std::string>{"old"});
}

}  // namespace
}  // namespace tactile_clay::files::files_test
