#include "files/output_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "files/input_file.h"

namespace tactile_clay::files {
namespace {

constexpr mode_t usual_mode = 0644;

[[noreturn]] void failTo(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}
[[noreturn]] void failToWrite(const std::string& file, int error) {
  failTo(file, std::string("cannot be written (") + std::strerror(error) +
                   "), expected a name in a folder to write to");
}

/// The file to which a link leads, or the name itself if it is no link.
std::string target(const std::string& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) return file;
  char resolved[PATH_MAX];
  if (::realpath(file.c_str(), resolved) == nullptr)
    failTo(file, "is a link that leads nowhere, expected a regular file or a new name");
  return resolved;
}

/// @return the permissions for the new file
mode_t judge(const std::string& file, Existing existing) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) return usual_mode;
  if (!S_ISREG(status.st_mode)) failTo(file, "is not a regular file, expected one or a new name");
  if (existing == Existing::keep) failTo(file, "exists already, expected a new name");
  return status.st_mode & 07777U;
}

/// A temporary file under a name of its own. It is deleted unless it was renamed.
class Part {
 public:
  explicit Part(const std::string& file)
      : file_(file), name_(file + ".XXXXXX"), opened_(::mkostemp(&name_[0], O_CLOEXEC)) {
    if (opened_.get() < 0) failToWrite(file_, errno);
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  ~Part() {
    if (!renamed_) ::unlink(name_.c_str());
  }

  void write(const std::string& content, mode_t mode) {
    std::size_t written = 0;
    while (written < content.size()) {
      const ssize_t n = ::write(opened_.get(), content.data() + written, content.size() - written);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) failToWrite(file_, errno);
      written += static_cast<std::size_t>(n);
    }
    if (::fchmod(opened_.get(), mode) != 0 || ::fsync(opened_.get()) != 0) failToWrite(file_, errno);
  }

  void takeName(Existing existing) {
    const unsigned flags = existing == Existing::keep ? RENAME_NOREPLACE : 0U;
    int error = ::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, file_.c_str(), flags) == 0 ? 0 : errno;
    // This file system cannot check and rename in one operation: a file that took the name in the last
    // microseconds may be lost.
    if (error == EINVAL) error = ::rename(name_.c_str(), file_.c_str()) == 0 ? 0 : errno;
    if (error == EEXIST) failTo(file_, "exists already, expected a new name");
    if (error != 0) failToWrite(file_, error);
    renamed_ = true;
  }

 private:
  std::string file_, name_;
  Descriptor opened_;
  bool renamed_ = false;
};

/// Writes the folder to the disk, so that the new name is there, too.
void syncFolderOf(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : file.substr(0, slash + 1);
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some file systems cannot do this for a folder; the file itself is safe.
  if (opened.get() >= 0) ::fsync(opened.get());
}

}  // namespace

void writeWhole(const std::string& file, const std::string& content, Existing existing) {
  if (file.empty() || file.find('\0') != std::string::npos)
    failTo(file.substr(0, file.find('\0')), "is no name of a file, expected one");
  const std::string path = target(file);
  const mode_t mode = judge(path, existing);
  Part part(path);
  part.write(content, mode);
  part.takeName(existing);
  syncFolderOf(path);
}

}  // namespace tactile_clay::files
