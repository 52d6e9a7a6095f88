#include "host/base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

#include "host/base/file_operations.hpp"
#include "weft/error.hpp"

namespace weft {
namespace {

namespace fs = std::filesystem;

/// An open file; closes and, unless kept, removes it.
class OpenFile {
 public:
  OpenFile(fs::path path, int flags, bool temporary)
      : path_(std::move(path)),
        descriptor_(::open(path_.c_str(), flags | O_CLOEXEC, 0666)),
        temporary_(temporary) {
    if (descriptor_ < 0) fail_on(path_, "open for writing");
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (temporary_) ::unlink(path_.c_str());
  }

  void write(std::string_view bytes) const { write_all(path_, descriptor_, bytes); }
  void sync() const {
    if (::fsync(descriptor_) != 0) fail_on(path_, "fsync");
  }
  /// Writes wait for a slow reader again.
  void wait_from_now_on() const {
    const int flags = ::fcntl(descriptor_, F_GETFL);
    if (flags < 0 || ::fcntl(descriptor_, F_SETFL, flags & ~O_NONBLOCK) < 0)
      fail_on(path_, "write");
  }
  void close() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0) fail_on(path_, "close");
  }
  void rename_to(const fs::path& target) {
    if (::rename(path_.c_str(), target.c_str()) != 0) fail_on(target, "replace");
    temporary_ = false;
  }

 private:
  fs::path path_;
  int descriptor_;
  bool temporary_;
};

/// What a symbolic link points to, whether that exists or not.
fs::path behind_links(fs::path path) {
  constexpr int links_max = 40;  // as many as the kernel follows
  std::error_code error;
  for (int k = 0; k < links_max && fs::is_symlink(path, error); ++k) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = path.parent_path() / next;
  }
  return path;
}

/// The rename itself is durable only once the directory is.
void sync_directory(const fs::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // a directory that may be written but not read: nothing to be done
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes, Durability durability) {
  std::error_code error;
  const fs::path target = behind_links(path);
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) fail_on(path, "write", EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    // A pipe that nobody reads is an error, not a wait without end.
    OpenFile file(target, O_WRONLY | O_NONBLOCK | O_NOCTTY, false);
    file.wait_from_now_on();
    file.write(bytes);
    return;
  }

  static std::atomic<unsigned> serial{0};
  const fs::path directory = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::string name = ".";
  name += target.filename().string();
  name += '.' + std::to_string(::getpid()) + '.' + std::to_string(serial++) + ".tmp";
  const fs::path temporary_name = directory / name;
  try {
    OpenFile temporary(temporary_name, O_WRONLY | O_CREAT | O_EXCL, true);
    temporary.write(bytes);
    if (durability == Durability::fsync) temporary.sync();
    temporary.close();
    temporary.rename_to(target);
  } catch (const SceneError& inner) {
    // The caller knows the file by its own name, not by that of the temporary one.
    std::string text = inner.what();
    const std::string from = temporary_name.string();
    if (text.compare(0, from.size(), from) == 0) text.replace(0, from.size(), path.string());
    throw SceneError(text);
  }
  if (durability == Durability::fsync) sync_directory(directory);
}

}  // namespace weft
