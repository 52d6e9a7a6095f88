#include "host/render/png_file.hpp"

#include <png.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include "weft/error.hpp"

namespace weft::io {
namespace {

/// File beside its final place, removed again unless it is renamed.
class PartFile {
 public:
  /// Takes the first free name "<path>.<number>.part"; creation is exclusive, so that two writers
  /// of one path, in one process or in two, never share a file.
  explicit PartFile(const std::filesystem::path& path) : path_(path) {
    for (int number = 0; number < 1000 && file == nullptr; ++number) {
      name_ = path;
      name_ += "." + std::to_string(number) + ".part";
      file = std::fopen(name_.c_str(), "wbx");
      if (file == nullptr && errno != EEXIST) break;
    }
    if (file == nullptr)
      throw SceneError(path.string(), "picture", std::strerror(errno),
                       "a file that can be written");
  }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;
  ~PartFile() {
    if (file != nullptr) std::fclose(file);
    std::error_code ignored;
    if (!placed_) std::filesystem::remove(name_, ignored);
  }

  /// Closes the file and moves it to its place.
  /// @return empty if all is well, otherwise what went wrong
  std::string place() {
    // A full disk may show only when the last buffer is flushed.
    const int status = std::fclose(file);
    file = nullptr;
    if (status != 0) return std::strerror(errno);
    std::error_code error;
    std::filesystem::rename(name_, path_, error);
    placed_ = !error;
    return error ? error.message() : std::string();
  }

  std::FILE* file = nullptr;

 private:
  std::filesystem::path path_;
  std::filesystem::path name_;
  bool placed_ = false;
};

void check(const std::filesystem::path& path, const Image& image) {
  if (image.width < 1 || image.height < 1)
    throw SceneError(path.string(), "image size",
                     std::to_string(image.width) + " x " + std::to_string(image.height),
                     "1 x 1 or more");
  const std::size_t expected = std::size_t{3} * static_cast<std::size_t>(image.width) *
                               static_cast<std::size_t>(image.height);
  if (image.rgb.size() != expected)
    throw SceneError(path.string(), "image bytes", std::to_string(image.rgb.size()),
                     "3 * width * height = " + std::to_string(expected));
}

/// libpng's simplified writer reports by return value, so no longjmp crosses a destructor.
/// @return empty if all is well, otherwise what went wrong
std::string encode(std::FILE* file, const Image& image) {
  png_image header;
  std::memset(&header, 0, sizeof header);
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  if (png_image_write_to_stdio(&header, file, 0, image.rgb.data(), 0, nullptr) == 0) {
    const std::string message = header.message;
    png_image_free(&header);
    return message;
  }
  return {};
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  check(path, image);
  PartFile part(path);
  std::string problem = encode(part.file, image);
  if (problem.empty()) problem = part.place();
  if (!problem.empty())
    throw SceneError(path.string(), "picture", problem, "a file that can be written");
}

}  // namespace weft::io
