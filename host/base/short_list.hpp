#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>

#include "weft/core/assert.hpp"

namespace weft {

/// A list of at most N items that needs no memory of its own.
template <class T, std::size_t N>
class ShortList {
 public:
  ShortList() noexcept {}  // the items are set when they are put in
  ShortList(std::initializer_list<T> items) {
    for (const T& item : items) push_back(item);
  }
  /// @pre size() < N
  void push_back(const T& value) {
    WEFT_ASSERT(count_ < N);
    items_[count_++] = value;
  }
  /// @pre not empty
  void pop_back() {
    WEFT_ASSERT(count_ > 0);
    --count_;
  }
  void clear() noexcept { count_ = 0; }
  /// Leaves out all items from `count` on.
  void shorten(std::size_t count) {
    WEFT_ASSERT(count <= count_);
    count_ = count;
  }

  std::size_t size() const noexcept { return count_; }
  bool empty() const noexcept { return count_ == 0; }
  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  T& back() { return items_[count_ - 1]; }
  T* begin() noexcept { return items_.data(); }
  T* end() noexcept { return items_.data() + count_; }
  const T* begin() const noexcept { return items_.data(); }
  const T* end() const noexcept { return items_.data() + count_; }

 private:
  std::array<T, N> items_;
  std::size_t count_ = 0;
};

}  // namespace weft
