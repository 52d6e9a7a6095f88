#include "host/app/time_parallel/slice_protocol.hpp"

#include <fmt/format.h>

#include <exception>
#include <functional>
#include <sstream>

#include "host/app/time_parallel/slice_sink.hpp"
#include "weft/error.hpp"

namespace weft::app {
namespace {

[[noreturn]] void rethrow(const std::string& kind, const std::string& text) {
  if (kind == "SceneError") throw SceneError(text);
  if (kind == "DeviceError") throw DeviceError(text);
  throw SimulationError(text);
}

/// Asks who decides.
class AskingGate : public SliceGate {
 public:
  explicit AskingGate(SliceAskerLink& asker) : asker_(asker) {}

  bool may_step(std::int64_t done) override {
    const char answer = ask(fmt::format("m {}", done));
    stopping_ = stopping_ || (answer != '0' && answer != '1');
    return answer == '1';
  }
  bool recovering(double work) override {
    stopping_ = stopping_ || ask(fmt::format("r {:.17g}", work)) != '1';
    return !stopping_;
  }
  void stepped(std::int64_t done, const std::vector<double>& work) override {
    std::string line = fmt::format("{} {}", told_ == 0 ? 'b' : 'w', done);
    for (; told_ < work.size(); ++told_) line += fmt::format(" {:.17g}", work[told_]);
    asker_.say(line);
  }
  bool stopping() override { return stopping_; }

 private:
  char ask(const std::string& question) {
    asker_.say(question);
    return asker_.answer();
  }
  SliceAskerLink& asker_;
  bool stopping_ = false;
  std::size_t told_ = 0;
};

}  // namespace

void hear_slice(const std::string& line, SliceWorkerLink& worker, SliceGate& gate,
                HeardOfSlice& heard) {
  std::istringstream words(line);
  std::string what;
  words >> what;
  if (what == "r") {
    double work = 0;
    words >> work;
    worker.answer(gate.recovering(work) ? '1' : '0');
  } else if (what == "m") {
    const bool may = gate.may_step(heard.done);
    heard.over = !may;
    worker.answer(may ? '1' : gate.stopping() ? '2' : '0');
  } else if (what == "w" || what == "b") {
    if (what == "b") heard.work.clear();
    words >> heard.done;
    for (double work = 0; words >> work;) heard.work.push_back(work);
    heard.stepped = heard.stepped || what == "w";
    gate.stepped(heard.done, heard.work);
  } else if (what == "e") {
    std::string kind, text;
    words >> kind;
    std::getline(words >> std::ws, text);
    rethrow(kind, text);
  } else if (what == "f") {
    int failure = 0;
    words >> failure;
    heard.failure = static_cast<Failure>(failure);
    std::getline(words >> std::ws, heard.failure_detail);
  }
}

void simulate_slice_for(SliceAskerLink& asker, const TimeParallelScene& scene,
                        const SliceTask& task, const std::string& device) {
  say_errors(asker, [&] {
    DiskSink sink(task.run);
    AskingGate gate(asker);
    const SliceOutcome outcome =
        run_slice(scene.fine(), scene.coarse(), task, parse_devices(device), gate, sink);
    if (outcome.failure != Failure::none)
      asker.say(fmt::format("f {} {}", static_cast<int>(outcome.failure), outcome.failure_detail));
  });
}

void say_errors(SliceAskerLink& asker, const std::function<void()>& work) {
  const auto say = [&](const char* kind, const std::exception& error) {
    asker.say(fmt::format("e {} {}", kind, error.what()));
  };
  try {
    work();
  } catch (const SceneError& error) {
    say("SceneError", error);
  } catch (const DeviceError& error) {
    say("DeviceError", error);
  } catch (const std::exception& error) {
    say("SimulationError", error);
  }
}

}  // namespace weft::app
