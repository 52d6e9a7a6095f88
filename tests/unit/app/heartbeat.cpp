// What a log gets to read of long steps. Linked with the program's own objects, see
// tests/CMakeLists.txt.
#include "host/app/run/heartbeat.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "host/app/run/progress.hpp"

namespace weft::app {
namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

std::string text_of(std::FILE* file) {
  std::string text;
  std::rewind(file);
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  return text;
}

StepProgress at(std::int64_t number, double seconds) {
  StepProgress p;
  p.number = number;
  p.seconds = seconds;
  p.stage = StepStage::solve;
  return p;
}

TEST(Heartbeat, LogsGetFewLines) {
  const File log(std::tmpfile());
  ASSERT_NE(log, nullptr);
  Progress progress(log.get(), 1, 25, 1);
  progress.during_step({});
  for (const double s : {0.5, 0.99, 1.2, 1.5, 9.9, 10.1, 59.0, 60.2, 119.0, 121.0, 179.0, 400.0})
    progress.during_step(at(3, s));
  for (const double s : {0.9, 25.0, 30.0, 61.0}) progress.during_step(at(4, s));
  const auto line = [](int number, int seconds) { return describe(at(number, seconds)) + "\n"; };
  EXPECT_EQ(text_of(log.get()), line(3, 1) + line(3, 10) + line(3, 60) + line(3, 121) +
                                    line(3, 400) + line(4, 25) + line(4, 61));
}

TEST(Heartbeat, ShowsAStepOnlyWhileItIsWatched) {
  using namespace std::chrono_literals;
  const File log(std::tmpfile());
  ASSERT_NE(log, nullptr);
  Progress progress(log.get(), 1, 25, 1);
  std::atomic<int> asked{0};
  const auto wait_for_looks = [&](int count) {
    for (int n = 0; n < 10'000 && asked < count; ++n) std::this_thread::sleep_for(1ms);
  };
  {
    Heartbeat heartbeat(
        progress, [&] { return at(1, 0.7 * ++asked); }, 1ms);
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(asked, 0);
    {
      const Heartbeat::Watch watch(heartbeat);
      wait_for_looks(3);
    }
    const int last = asked;
    EXPECT_GE(last, 3);
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(asked, last) << "the step is over";
  }
  EXPECT_EQ(text_of(log.get()).rfind(describe(at(1, 1.4)) + "\n", 0), 0U) << text_of(log.get());
}

}  // namespace
}  // namespace weft::app
