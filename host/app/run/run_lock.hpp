#pragma once

#include <filesystem>

namespace weft::app {

/// Keeps a directory to this process: as long as this lives, no other run may write there. The
/// kernel releases the lock when the process ends, whatever ends it. Programs that this one starts
/// do not inherit it.
class RunLock {
 public:
  /// The file in the directory that is locked. It stays there, so that no two processes can lock
  /// two files of that name.
  static constexpr const char* file_name = ".weft.lock";

  /// @throws SceneError naming the directory and the other process if another run has it, or if
  ///         the lock cannot be made
  explicit RunLock(const std::filesystem::path& directory);
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock();

 private:
  int descriptor_;
};

}  // namespace weft::app
