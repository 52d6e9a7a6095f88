#pragma once

#include <atomic>
#include <chrono>
#include <thread>

namespace weft {

/// Leaves the core to its other hardware thread for a moment.
inline void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Whether a value changes before its reader had better sleep: waking a thread takes 50 to 100
/// microseconds in a virtual machine, and most waits are shorter. Others that want the core get it
/// meanwhile, since the value may depend on them.
/// @param value std::atomic or std::atomic_ref
template <class Atomic>
bool changes_soon(const Atomic& value, typename Atomic::value_type old) noexcept {
  constexpr std::chrono::microseconds patience{100};
  constexpr int looks_in_a_row = 32;
  const auto begin = std::chrono::steady_clock::now();
  do {
    for (int look = 0; look < looks_in_a_row; ++look, relax())
      if (value.load(std::memory_order_acquire) != old) return true;
    std::this_thread::yield();
  } while (std::chrono::steady_clock::now() - begin < patience);
  return false;
}

/// Blocks until a value is another than `old`. Whoever changes it notifies.
/// @param value std::atomic or std::atomic_ref
template <class Atomic>
void wait_for_change(const Atomic& value, typename Atomic::value_type old) noexcept {
  if (!changes_soon(value, old)) value.wait(old, std::memory_order_acquire);
}

}  // namespace weft
