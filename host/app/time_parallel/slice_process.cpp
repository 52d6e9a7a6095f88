#include "host/app/time_parallel/slice_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "host/app/process/child.hpp"
#include "host/app/run/allow_path.hpp"
#include "host/app/time_parallel/slice_protocol.hpp"
#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

extern char** environ;

namespace weft::app {
namespace {

namespace fs = std::filesystem;

/// A slice whose process is lost that often in a row, without a step in between, is given up.
constexpr int losses_max = 10;

class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_, O_CLOEXEC) != 0)
      throw DeviceError("pipe: " + std::generic_category().message(errno));
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    for (int i = 0; i < 2; ++i) close(i);
  }
  int read_end() const { return ends_[0]; }
  int write_end() const { return ends_[1]; }
  void close(int which) {
    if (ends_[which] >= 0) ::close(ends_[which]);
    ends_[which] = -1;
  }

 private:
  int ends_[2] = {-1, -1};
};

/// A process that runs `weft slice`, and the lines to and from it.
class Child : public SliceWorkerLink {
 public:
  Child(const fs::path& scene, const std::vector<std::string>& folders, const std::string& device,
        const SliceTask& task) {
    std::vector<std::string> words{"weft",
                                   "slice",
                                   scene.string(),
                                   task.run.string(),
                                   std::to_string(task.number),
                                   std::to_string(task.first_step),
                                   device};
    const std::vector<std::string> allowed = allow_path_words(folders);
    words.insert(words.end(), allowed.begin(), allowed.end());
    std::vector<char*> arguments = argument_list(words);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, to_.read_end(), 0);
    posix_spawn_file_actions_adddup2(&actions, from_.write_end(), 1);
    const int error =
        ::posix_spawn(&id_, "/proc/self/exe", &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0)
      throw DeviceError("a process for slice " + std::to_string(task.number) + ": " +
                        std::generic_category().message(error));
    to_.close(0);
    from_.close(1);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  /// Takes its input away, at which it ends, and waits.
  ~Child() override {
    to_.close(1);
    from_.close(0);
    while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }

  std::optional<std::string> line() override {
    for (;;) {
      const auto end = pending_.find('\n');
      if (end != std::string::npos) {
        std::string result = pending_.substr(0, end);
        pending_.erase(0, end + 1);
        return result;
      }
      char buffer[4096];
      const ssize_t count = ::read(from_.read_end(), buffer, sizeof buffer);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return std::nullopt;
      pending_.append(buffer, static_cast<std::size_t>(count));
    }
  }
  void answer(char c) override {
    const char text[2] = {c, '\n'};
    while (::write(to_.write_end(), text, sizeof text) < 0 && errno == EINTR) {
    }
  }

 private:
  Pipe to_, from_;
  pid_t id_ = -1;
  std::string pending_;
};

// ---- the other end

class StandardStreams : public SliceAskerLink {
 public:
  void say(const std::string& line) override {
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }
  char answer() override {
    char text[8] = {};
    return std::fgets(text, sizeof text, stdin) != nullptr ? text[0] : '2';
  }
};

struct SliceRequest {
  std::string scene, run, device;
  std::vector<std::string> allowed;
  int number = 0;
  std::int64_t first_step = 0;
};

int run_slice_of(const SliceRequest& request) {
  // Ctrl-C reaches all processes of a terminal; the parent says when to stop.
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGPIPE, SIG_IGN);
  StandardStreams parent;
  say_errors(parent, [&] {
    const TimeParallelScene scene(io::read_scene(request.scene, {}, request.allowed), 1);
    simulate_slice_for(parent, scene, {request.number, request.first_step, request.run},
                       request.device);
  });
  return 0;
}

}  // namespace

SliceOutcome run_slice_process(const fs::path& scene, const std::vector<std::string>& folders,
                               const std::string& device, const SliceTask& task, SliceGate& gate,
                               const std::function<void()>& frame) {
  ::signal(SIGPIPE, SIG_IGN);  // a process that was killed does not read its answers
  SliceOutcome outcome;
  for (int losses = 0; losses < losses_max;) {
    HeardOfSlice heard;
    {
      Child child(scene, folders, device, task);
      while (const auto line = child.line()) {
        hear_slice(*line, child, gate, heard);
        if (heard.stepped) frame();
      }
    }
    outcome.failure = heard.failure;
    outcome.failure_detail = heard.failure_detail;
    outcome.end = heard.done;
    if (heard.failure != Failure::none || gate.stopping()) return outcome;
    if (auto finished = finished_slice(task)) {
      frame();
      return *finished;
    }
    losses = heard.stepped ? 0 : losses + 1;
  }
  throw DeviceError(
      fmt::format("the process of slice {} was lost {} times in a row", task.number, losses_max));
}

void add_slice_subcommand(CLI::App& app, int& exit_code) {
  auto* subcommand = app.add_subcommand("slice", "");
  subcommand->group("");
  auto request = std::make_shared<SliceRequest>();
  subcommand->add_option("scene", request->scene)->required();
  subcommand->add_option("run", request->run)->required();
  subcommand->add_option("number", request->number)->required();
  subcommand->add_option("first_step", request->first_step)->required();
  subcommand->add_option("device", request->device)->required();
  add_allow_path(*subcommand, request->allowed);
  subcommand->callback([request, &exit_code] { exit_code = run_slice_of(*request); });
}

}  // namespace weft::app
