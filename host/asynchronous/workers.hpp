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

/// Threads that do one piece of work together, again and again. What they compute must not depend
/// on how it is shared out.
class Workers {
 public:
  /// @param count threads in all, the caller's included; >= 1
  explicit Workers(int count);
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers();

  int size() const noexcept { return static_cast<int>(threads_.size()) + 1; }

  /// Calls work(0) .. work(parts - 1), each on a thread of its own, and waits for all of them.
  /// Other threads sleep on.
  /// @param parts 1 to size()
  /// @throws what the first of them threw, by number; what others threw is lost
  void run(int parts, const std::function<void(int)>& work);

  /// Threads that share() gives work to: no more than get `least` each.
  int parts_of(std::size_t count, std::size_t least) const noexcept {
    return static_cast<int>(
        std::clamp(count / least, std::size_t{1}, static_cast<std::size_t>(size())));
  }

  /// Calls work(first, last) for runs that make up [0, count), one a thread.
  void share(std::size_t count, std::size_t least,
             const std::function<void(std::size_t, std::size_t)>& work);

  /// Calls work(i) for every i below count, in any order: each thread takes the next one when it
  /// is free.
  void take_turns(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void call(int parts);
  void serve(int number);
  void work_as(int number) noexcept;

  /// Raised when there is work for a thread, on a cache line of its own.
  struct alignas(64) Call {
    std::atomic<std::uint32_t> round{0};
    std::atomic<bool> asleep{false};  ///< the thread has to be woken
  };

  std::vector<std::thread> threads_;
  std::unique_ptr<Call[]> calls_;  ///< [size()]
  const std::function<void(int)>* work_ = nullptr;
  std::vector<std::exception_ptr> thrown_;
  std::atomic<int> busy_{0};  ///< threads that have not finished this round
  std::atomic<bool> stop_{false};
};

}  // namespace weft
