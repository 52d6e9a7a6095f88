#include "host/app/render/movie.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/file_descriptor.hpp"
#include "weft/error.hpp"

extern char** environ;

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// A name beside `path` that belongs to this process alone.
fs::path name_beside(const fs::path& path, const std::string& ending) {
  return path.parent_path() / fmt::format(".{}.{}{}", path.stem().string(), ::getpid(), ending);
}

std::vector<std::string> arguments_of(const fs::path& part, int width, int height, double rate) {
  return {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo",
          "-pixel_format", "rgb24", "-video_size", fmt::format("{}x{}", width, height),
          "-framerate", fmt::format("{}", rate), "-i", "pipe:0",
          // H.264 with halved colour channels needs even sizes.
          "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p", "-c:v", "libx264", "-preset",
          "medium", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4",
          // A name that begins with a dash would be an option.
          fs::absolute(part).string()};
}

/// Starts ffmpeg.
/// @param input its standard input
/// @param log   for what it says
/// @return 0, or the number of the error
int start(std::vector<std::string> arguments, int input, int log, pid_t& child) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, log, 2);
  const int status = ::posix_spawnp(&child, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return status;
}

std::string last_line(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line, last;
  while (std::getline(stream, line))
    if (!line.empty()) last = line.substr(0, 300);
  return last;
}

}  // namespace

Movie::Movie(fs::path path, int width, int height, double rate)
    : path_(std::move(path)),
      part_(name_beside(path_, ".part")),
      log_(name_beside(path_, ".log")),
      width_(width),
      height_(height) {
  if (path_.extension() != ".mp4")
    throw SceneError("", "--movie", path_.string(), "a file name that ends in .mp4");
  const FileDescriptor log(::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (log.number() < 0)
    throw SceneError("", "--movie", path_.string() + ": " + std::strerror(errno),
                     "a file in a folder that can be written");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    throw SceneError("", "--movie", std::strerror(errno), "a pipe to ffmpeg");
  const int status = start(arguments_of(part_, width, height, rate), ends[0], log.number(), child_);
  ::close(ends[0]);
  pipe_ = ends[1];
  if (status == 0) return;
  child_ = -1;
  ::close(std::exchange(pipe_, -1));
  std::error_code ignored;
  fs::remove(log_, ignored);  // no destructor follows
  if (status == ENOENT)
    throw SceneError("", "--movie", path_.string() + " without the program ffmpeg",
                     "a film if ffmpeg is installed; for pictures only, omit --movie");
  throw SceneError("", "--movie", "ffmpeg: " + std::string(std::strerror(status)),
                   "a program ffmpeg that starts, and a folder that can be written");
}

Movie::~Movie() {
  if (pipe_ >= 0) ::close(pipe_);
  if (child_ > 0) ::kill(child_, SIGTERM);
  wait();
  std::error_code ignored;
  fs::remove(part_, ignored);
  fs::remove(log_, ignored);
}

int Movie::wait() {
  int status = 0;
  if (child_ > 0)
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
  child_ = -1;
  return status;
}

void Movie::fail(const std::string& what) {
  const std::string said = last_line(log_);
  throw SceneError(path_.string(), "--movie", what + (said.empty() ? "" : ": " + said),
                   "a film that ffmpeg can write");
}

void Movie::add(const io::Image& image) {
  if (image.width != width_ || image.height != height_)
    throw SceneError(path_.string(), "--movie", "a picture of another size", "one size for all");
  // An ffmpeg that has ended must be an error here, not the end of this program.
  const auto before = ::signal(SIGPIPE, SIG_IGN);
  std::size_t done = 0;
  int problem = 0;
  while (done < image.rgb.size() && problem == 0) {
    const ssize_t n = ::write(pipe_, image.rgb.data() + done, image.rgb.size() - done);
    if (n > 0)
      done += static_cast<std::size_t>(n);
    else if (errno != EINTR)
      problem = errno;
  }
  ::signal(SIGPIPE, before);
  if (problem == 0) return;
  ::close(std::exchange(pipe_, -1));
  wait();
  fail("ffmpeg ended early");
}

void Movie::finish() {
  ::close(std::exchange(pipe_, -1));
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail("ffmpeg failed");
  std::error_code error;
  fs::rename(part_, path_, error);
  if (error) fail(error.message());
}

}  // namespace weft::app
