#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace weft {

/// A fixed number of threads that share pieces of work. Results must not depend on how
/// the work is divided.
class Workers {
 public:
  /// @param count number of threads, including the caller's; >= 1
  explicit Workers(int count);
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers();

  int size() const noexcept { return static_cast<int>(threads_.size()) + 1; }

  /// Calls work(0) .. work(parts - 1), each on a different thread, and waits for all of them. The
  /// other threads are not woken.
  /// @param parts 1 to size()
  /// @throws the exception of the lowest-numbered call that threw; other exceptions are lost
  void run(int parts, const std::function<void(int)>& work);

  /// Number of threads that share() uses, so that each gets at least `least` items.
  int parts_of(std::size_t count, std::size_t least) const noexcept {
    return static_cast<int>(
        std::clamp(count / least, std::size_t{1}, static_cast<std::size_t>(size())));
  }

  /// Divides [0, count) into ranges, one per thread, and calls work(first, last) for each.
  void share(std::size_t count, std::size_t least,
             const std::function<void(std::size_t, std::size_t)>& work);

  /// Calls work(i) for every i below count, in any order. A thread that is free takes the next i.
  void take_turns(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void call(int parts);
  void serve(int number);
  void work_as(int number) noexcept;

  /// Signals work to one thread. Each has its own cache line.
  struct alignas(64) Call {
    std::atomic<std::uint32_t> round{0};
    std::atomic<bool> asleep{false};  ///< the thread must be woken
  };

  std::vector<std::thread> threads_;
  std::unique_ptr<Call[]> calls_;  ///< [size()]
  const std::function<void(int)>* work_ = nullptr;
  std::vector<std::exception_ptr> thrown_;
  std::atomic<int> busy_{0};  ///< threads that have not finished this round
  std::atomic<bool> stop_{false};
};

}  // namespace weft
