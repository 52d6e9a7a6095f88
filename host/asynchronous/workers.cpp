#include "host/asynchronous/workers.hpp"

#include <algorithm>

namespace weft {
namespace {

/// Looks at an atomic for a moment before the thread goes to sleep: a tick takes microseconds.
constexpr int looks = 2000;

template <class T>
void wait_while(const std::atomic<T>& value, T old) {
  for (int k = 0; k < looks; ++k)
    if (value.load(std::memory_order_acquire) != old) return;
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

Workers::Workers(int count) : thrown_(static_cast<std::size_t>(std::max(count, 1))) {
  for (int n = 1; n < count; ++n) threads_.emplace_back([this, n] { serve(n); });
}

Workers::~Workers() {
  stop_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::work_as(int number) noexcept {
  try {
    (*work_)(number);
  } catch (...) {
    thrown_[static_cast<std::size_t>(number)] = std::current_exception();
  }
}

void Workers::serve(int number) {
  for (std::uint32_t seen = 0;;) {
    wait_while(round_, seen);
    seen = round_.load(std::memory_order_acquire);
    if (stop_) return;
    work_as(number);
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_all();
  }
}

void Workers::run(const std::function<void(int)>& work) {
  work_ = &work;
  busy_.store(static_cast<int>(threads_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
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
  if (!shares(count, least)) return work(0, count);
  const auto parts = static_cast<std::size_t>(size());
  run([&](int n) {
    const auto part = static_cast<std::size_t>(n);
    work(count * part / parts, count * (part + 1) / parts);
  });
}

void Workers::take_turns(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (size() == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  run([&](int) {
    for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed))
      work(i);
  });
}

}  // namespace weft
