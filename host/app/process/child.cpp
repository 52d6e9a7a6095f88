#include "host/app/process/child.hpp"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string_view>
#include <thread>

#include "host/base/file_operations.hpp"

extern char** environ;

namespace weft::app {
namespace {

std::string last_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("weft: ") && !line.starts_with("weft: warning")) last = line.substr(6);
  return last;
}

/// In the child: nothing but what is safe between fork and exec.
[[noreturn]] void become(char** argv, int log, const cpu_set_t* cores) {
  if (cores != nullptr && ::sched_setaffinity(0, sizeof *cores, cores) != 0) ::_exit(126);
  if (::dup2(log, 1) < 0 || ::dup2(log, 2) < 0) ::_exit(126);
  ::execv("/proc/self/exe", argv);
  ::_exit(127);
}

}  // namespace

ChildEnd run_child(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                   double limit, const std::vector<int>& cores) {
  std::vector<std::string> words{"weft"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv = argument_list(words);
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail_on(log, "write");
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int core : cores) CPU_SET(static_cast<unsigned>(core), &set);
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) become(argv.data(), file, cores.empty() ? nullptr : &set);
  ::close(file);
  if (child < 0) fail_on("weft run", "start");
  const auto start = std::chrono::steady_clock::now();
  ChildEnd end;
  int status = 0;
  while (::waitpid(child, &status, limit > 0 ? WNOHANG : 0) == 0) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    if (spent.count() > limit && !end.timed_out) {
      end.timed_out = true;
      ::kill(child, SIGKILL);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  end.message = last_line(log);
  return end;
}

std::optional<ChildEnd> run_program(std::vector<std::string> words,
                                    const std::filesystem::path& folder,
                                    const std::filesystem::path& log) {
  std::vector<char*> argv = argument_list(words);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) return std::nullopt;
  if (error != 0) fail_on(words[0], "start", error);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ChildEnd end;
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  std::ifstream in(log);
  for (std::string line; std::getline(in, line);)
    if (line.find_first_not_of(" \t\r^") != std::string::npos) end.message = line;
  return end;
}

std::vector<char*> argument_list(std::vector<std::string>& words) {
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

std::vector<std::vector<int>> core_groups(int count) {
  cpu_set_t set;
  std::vector<int> cores;
  if (::sched_getaffinity(0, sizeof set, &set) == 0)
    for (int core = 0; core < CPU_SETSIZE; ++core)
      if (CPU_ISSET(static_cast<unsigned>(core), &set)) cores.push_back(core);
  const auto groups = std::clamp<std::size_t>(static_cast<std::size_t>(std::max(1, count)), 1,
                                              std::max<std::size_t>(1, cores.size()));
  const std::size_t size = cores.size() / groups;
  std::vector<std::vector<int>> result(groups);
  for (std::size_t g = 0; g < groups; ++g)
    for (std::size_t k = 0; k < size; ++k) result[g].push_back(cores[g * size + k]);
  return result;
}

std::string shell_text(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
             std::string_view("_-./=:,+@%").find(c) != std::string_view::npos;
    });
    text += (text.empty() ? "" : " ");
    if (plain) {
      text += word;
      continue;
    }
    text += '\'';
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += '\'';
  }
  return text;
}

}  // namespace weft::app
