#include "host/io/file_bytes.hpp"

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>

#include "weft/error.hpp"

namespace weft::io {

namespace fs = std::filesystem;

std::string read_file_bytes(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status))
    throw SceneError(path.string() +
                     ": cannot read: " + (error ? error.message() : "No such file or directory"));
  if (!fs::is_regular_file(status))
    throw SceneError(path.string() + ": cannot read: not a regular file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw SceneError(path.string() + ": cannot read: " + error.message());
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw SceneError(path.string() + ": cannot read: " + std::generic_category().message(errno));
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  if (stream.bad()) throw SceneError(path.string() + ": cannot read: input error");
  return bytes;
}

}  // namespace weft::io
