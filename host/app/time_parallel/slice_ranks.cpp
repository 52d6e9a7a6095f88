#include "host/app/time_parallel/slice_ranks.hpp"

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "host/io/scene/scene_file.hpp"
#include "weft/error.hpp"

#ifdef WEFT_MPI
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#endif

namespace weft::app {
namespace {

/// What launchers tell the processes that they start: Open MPI, and those that speak PMI.
int launched_count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    const char* text = std::getenv(name);
    int count = 0;
    if (text == nullptr) continue;
    if (std::from_chars(text, text + std::strlen(text), count).ec == std::errc() && count > 1)
      return count;
  }
  return 1;
}

}  // namespace

void refuse_uncounted_ranks() {
  const char* rank = std::getenv("PMIX_RANK");
  if (rank != nullptr && std::string_view(rank) != "0" &&
      std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr && std::getenv("PMI_SIZE") == nullptr)
    throw SceneError("", "PMIX_RANK", rank,
                     "a launcher that tells how many processes there are, such as mpirun");
}

#ifdef WEFT_MPI

namespace {

/// MPI's own waiting spins; lines come seldom enough to look for them now and then.
constexpr std::chrono::microseconds pause{200};

enum Tag : int { task_tag, line_tag, answer_tag };
/// A task that is none: the rank may go. A line that is none: the slice is over.
constexpr std::string_view no_text{};

void send(int rank, Tag tag, std::string_view text) {
  MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, rank, tag, MPI_COMM_WORLD);
}

std::string receive(int rank, Tag tag) {
  MPI_Message message{};
  MPI_Status status{};
  for (int there = 0; there == 0;) {
    MPI_Improbe(rank, tag, MPI_COMM_WORLD, &there, &message, &status);
    if (there == 0) std::this_thread::sleep_for(pause);
  }
  int size = 0;
  MPI_Get_count(&status, MPI_CHAR, &size);
  std::string text(static_cast<std::size_t>(size), '\0');
  MPI_Mrecv(text.data(), size, MPI_CHAR, &message, &status);
  return text;
}

class RankLink : public SliceWorkerLink {
 public:
  explicit RankLink(int rank) : rank_(rank) {}
  std::optional<std::string> line() override {
    std::string text = receive(rank_, line_tag);
    if (text.empty()) return std::nullopt;
    return text;
  }
  void answer(char c) override { send(rank_, answer_tag, {&c, 1}); }

 private:
  int rank_;
};

class FirstRankLink : public SliceAskerLink {
 public:
  void say(const std::string& line) override { send(0, line_tag, line); }
  char answer() override { return receive(0, answer_tag).front(); }
};

}  // namespace

struct SliceRanks::State {
  int rank = 0;
  std::mutex mutex;
  std::vector<int> free;  ///< ranks without a slice
};

int mpi_rank_count() {
  return launched_count();
}

SliceRanks::SliceRanks() : state_(std::make_unique<State>()) {
  int given = MPI_THREAD_SINGLE, count = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_MULTIPLE, &given);
  MPI_Comm_rank(MPI_COMM_WORLD, &state_->rank);
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  for (int rank = count; rank-- > 1;) state_->free.push_back(rank);
  if (count != launched_count()) {
    MPI_Finalize();
    throw DeviceError(
        "MPI knows of " + std::to_string(count) + " of the " + std::to_string(launched_count()) +
        " processes that were started: take the mpirun of the MPI that weft was built "
        "with");
  }
  if (given >= MPI_THREAD_MULTIPLE) return;
  MPI_Finalize();
  throw DeviceError("this MPI serves one thread only: slices need MPI_THREAD_MULTIPLE");
}

SliceRanks::~SliceRanks() {
  if (first())
    for (const int rank : state_->free) send(rank, task_tag, no_text);
  MPI_Finalize();
}

bool SliceRanks::first() const {
  return state_->rank == 0;
}

void SliceRanks::serve(const std::vector<std::string>& folders) {
  FirstRankLink asker;
  std::optional<TimeParallelScene> level;  // of all tasks
  for (;;) {
    const std::string text = receive(0, task_tag);
    if (text.empty()) return;
    std::istringstream lines(text);
    std::string scene, run, device;
    SliceTask task;
    std::getline(lines, scene);
    std::getline(lines, run);
    std::getline(lines, device);
    lines >> task.number >> task.first_step;
    task.run = run;
    say_errors(asker, [&] {
      if (!level) level.emplace(io::read_scene(scene, {}, folders), 1);
      simulate_slice_for(asker, *level, task, device);
    });
    send(0, line_tag, no_text);
  }
}

bool SliceRanks::run(const std::filesystem::path& scene, const std::string& device,
                     const SliceTask& task, SliceGate& gate, const std::function<void()>& frame,
                     SliceOutcome& outcome) {
  int rank = 0;
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    if (state_->free.empty()) return false;
    rank = state_->free.back();
    state_->free.pop_back();
  }
  std::ostringstream text;
  text << std::filesystem::absolute(scene).string() << '\n'
       << std::filesystem::absolute(task.run).string() << '\n'
       << device << '\n'
       << task.number << ' ' << task.first_step;
  send(rank, task_tag, text.str());
  RankLink worker(rank);
  HeardOfSlice heard;
  std::exception_ptr error;
  while (const auto line = worker.line()) {
    if (error) {
      // The worker is to stop, and waits for what it asks.
      if (line->starts_with('m') || line->starts_with('r')) worker.answer('2');
      continue;
    }
    try {
      hear_slice(*line, worker, gate, heard);
    } catch (...) {
      error = std::current_exception();
      if (line->starts_with('m') || line->starts_with('r')) worker.answer('2');
      continue;
    }
    try {
      if (heard.stepped) frame();
    } catch (...) {
      error = std::current_exception();
    }
  }
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->free.push_back(rank);
  }
  if (error) std::rethrow_exception(error);
  if (const auto finished = finished_slice(task)) {
    frame();
    outcome = *finished;
    return true;
  }
  outcome.failure = heard.failure;
  outcome.failure_detail = heard.failure_detail;
  outcome.end = heard.done;
  return true;
}

#else

struct SliceRanks::State {};

int mpi_rank_count() {
  const int count = launched_count();
  if (count > 1)
    throw SceneError("", "mpirun", std::to_string(count) + " processes",
                     "1: this weft was built without MPI (WEFT_MPI)");
  return count;
}

SliceRanks::SliceRanks() {
  throw DeviceError("this weft was built without MPI (WEFT_MPI)");
}
SliceRanks::~SliceRanks() = default;
bool SliceRanks::first() const {
  return true;
}
void SliceRanks::serve(const std::vector<std::string>&) {}
bool SliceRanks::run(const std::filesystem::path&, const std::string&, const SliceTask&, SliceGate&,
                     const std::function<void()>&, SliceOutcome&) {
  return false;
}

#endif

}  // namespace weft::app
