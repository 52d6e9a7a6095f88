#include "host/io/mesh/assimp_files.hpp"

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/file_bytes.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

namespace fs = std::filesystem;

/// A file that has been read.
class BytesStream final : public Assimp::IOStream {
 public:
  explicit BytesStream(std::string bytes) : bytes_(std::move(bytes)) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t items = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, items * size);
    at_ += items * size;
    return items;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    // Unsigned: an offset back from the end or from here wraps around, as in assimp's own streams.
    const std::size_t start = origin == aiOrigin_SET   ? 0
                              : origin == aiOrigin_CUR ? at_
                                                       : bytes_.size();
    const std::size_t target = origin == aiOrigin_END ? start - offset : start + offset;
    if (target > bytes_.size()) return aiReturn_FAILURE;
    at_ = target;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

}  // namespace

bool AssimpFiles::Exists(const char* path) const {
  std::error_code error;
  return path == file_ || (folders_.contain(path) && fs::is_regular_file(path, error));
}

Assimp::IOStream* AssimpFiles::Open(const char* path, const char* mode) {
  if (std::string_view(mode).find_first_of("wa+") != std::string_view::npos) return nullptr;
  try {
    if (path != file_) {
      // Assimp guesses names; one that is not there is no attempt to read it.
      if (!is_there(path)) return nullptr;
      folders_.require(path, file_.string(), "file that it names");
    }
    return std::make_unique<BytesStream>(read_file_bytes(path)).release();
  } catch (const SceneError& error) {
    if (refusal_.empty()) refusal_ = error.what();
    return nullptr;
  }
}

void AssimpFiles::Close(Assimp::IOStream* stream) {
  delete stream;
}

}  // namespace weft::io
