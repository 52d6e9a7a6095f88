#pragma once

#include <sys/types.h>

#include <filesystem>

#include "host/render/png_file.hpp"

namespace weft::app {

/// A film that the program ffmpeg makes: H.264 in MP4, yuv420p, even sizes. It takes its name only
/// when it is whole.
class Movie {
 public:
  /// @param rate [1/s] pictures a second
  /// @throws SceneError if the file cannot be an MP4 film, or ffmpeg is missing or does not start
  Movie(std::filesystem::path path, int width, int height, double rate);
  Movie(const Movie&) = delete;
  Movie& operator=(const Movie&) = delete;
  ~Movie();

  /// Adds a picture of the film's size.
  /// @throws SceneError if ffmpeg has ended
  void add(const io::Image& image);

  /// Waits for ffmpeg and gives the film its name.
  /// @throws SceneError with the end of what ffmpeg said, if it failed
  void finish();

 private:
  [[noreturn]] void fail(const std::string& what);
  int wait();

  std::filesystem::path path_, part_, log_;
  int width_, height_;
  pid_t child_ = -1;
  int pipe_ = -1;
};

}  // namespace weft::app
