#pragma once

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace weft {

/// Memory of a device that serves one purpose.
struct MemoryUse {
  std::string name;            ///< what it is for
  std::size_t bytes = 0;       ///< now
  std::size_t peak_bytes = 0;  ///< at most so far
};

/// Says what the buffers are for that this thread makes while it lives: they are counted under that
/// name, also where they grow later. Nested names: the innermost counts.
class MemoryName {
 public:
  /// @param name a literal: kept as a pointer
  explicit MemoryName(const char* name) noexcept : outer_(current_) { current_ = name; }
  ~MemoryName() { current_ = outer_; }
  MemoryName(const MemoryName&) = delete;
  MemoryName& operator=(const MemoryName&) = delete;
  /// Another name from now on.
  void change(const char* name) noexcept { current_ = name; }
  /// "other" outside of any.
  static const char* current() noexcept { return current_; }

 private:
  inline static thread_local const char* current_ = "other";
  const char* outer_;
};

/// Counts memory by what it is for. Any thread may book.
class MemoryBook {
 public:
  /// @throws std::bad_alloc where there is no room for another name; nothing is counted then
  void add(std::string_view name, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    auto use = find(name);
    if (use == uses_.end() || use->name != name) use = uses_.insert(use, {std::string(name)});
    use->bytes += bytes;
    use->peak_bytes = std::max(use->peak_bytes, use->bytes);
  }
  /// Nothing, where the name was never added.
  /// @pre otherwise as much has been added
  void remove(std::string_view name, std::size_t bytes) noexcept {
    const std::scoped_lock lock(mutex_);
    const auto use = find(name);
    if (use != uses_.end() && use->name == name) use->bytes -= bytes;
  }
  /// Ordered by name.
  std::vector<MemoryUse> uses() const {
    const std::scoped_lock lock(mutex_);
    return uses_;
  }

 private:
  std::vector<MemoryUse>::iterator find(std::string_view name) noexcept {
    return std::lower_bound(
        uses_.begin(), uses_.end(), name,
        [](const MemoryUse& use, std::string_view n) { return std::string_view(use.name) < n; });
  }

  mutable std::mutex mutex_;
  std::vector<MemoryUse> uses_;
};

}  // namespace weft
