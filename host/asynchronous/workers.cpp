#include "host/asynchronous/workers.hpp"

#include <algorithm>

namespace weft {
namespace {

/// Looks at an atomic before the thread goes to sleep, some 40 microseconds of them: parts of ticks
/// take less, and waking up takes as long.
constexpr int looks = 1000;

/// Leaves the core to the other thread on it for a moment.
void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

template <class T>
void wait_while(const std::atomic<T>& value, T old) {
  for (int k = 0; k < looks; ++k, pause())
    if (value.load(std::memory_order_acquire) != old) return;
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

Workers::Workers(int count)
    : calls_(new Call[static_cast<std::size_t>(std::max(count, 1))]),
      thrown_(static_cast<std::size_t>(std::max(count, 1))) {
  for (int n = 1; n < count; ++n) threads_.emplace_back([this, n] { serve(n); });
}

Workers::~Workers() {
  stop_ = true;
  call(size());
  for (std::thread& thread : threads_) thread.join();
}

void Workers::call(int parts) {
  for (int n = 1; n < parts; ++n) {
    std::atomic<std::uint32_t>& round = calls_[static_cast<std::size_t>(n)].round;
    // Nobody else writes it: cheaper than an addition, which would wait for each.
    round.store(round.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    round.notify_one();
  }
}

void Workers::work_as(int number) noexcept {
  try {
    (*work_)(number);
  } catch (...) {
    thrown_[static_cast<std::size_t>(number)] = std::current_exception();
  }
}

void Workers::serve(int number) {
  const std::atomic<std::uint32_t>& round = calls_[static_cast<std::size_t>(number)].round;
  for (std::uint32_t seen = 0;;) {
    wait_while(round, seen);
    seen = round.load(std::memory_order_acquire);
    if (stop_) return;
    work_as(number);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_all();
  }
}

void Workers::run(int parts, const std::function<void(int)>& work) {
  work_ = &work;
  busy_.store(parts - 1, std::memory_order_relaxed);
  call(parts);
  work_as(0);
  for (int left = busy_.load(std::memory_order_acquire); left != 0;
       left = busy_.load(std::memory_order_acquire))
    wait_while(busy_, left);
  std::exception_ptr first;
  for (std::exception_ptr& thrown : thrown_) {
    if (!first) first = thrown;
    thrown = nullptr;
  }
  if (first) std::rethrow_exception(first);
}

void Workers::share(std::size_t count, std::size_t least,
                    const std::function<void(std::size_t, std::size_t)>& work) {
  const int parts = parts_of(count, least);
  if (parts == 1) return work(0, count);
  run(parts, [&](int n) {
    const auto part = static_cast<std::size_t>(n);
    const auto all = static_cast<std::size_t>(parts);
    work(count * part / all, count * (part + 1) / all);
  });
}

void Workers::take_turns(std::size_t count, const std::function<void(std::size_t)>& work) {
  const int parts = parts_of(count, 1);
  if (parts == 1) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  run(parts, [&](int) {
    for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed))
      work(i);
  });
}

}  // namespace weft
