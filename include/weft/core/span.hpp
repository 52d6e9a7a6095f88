#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "weft/core/assert.hpp"
#include "weft/core/hd.hpp"

namespace weft {

/// View of a contiguous array that device code can use as well (std::span cannot without nvcc's
/// relaxed-constexpr mode). Does not own; copying copies the view.
template <class T>
class Span {
 public:
  constexpr Span() noexcept = default;
  WEFT_HD constexpr Span(T* data, std::size_t size) noexcept : data_(data), size_(size) {}
  template <class U>
  requires(std::is_convertible_v<U (*)[], T (*)[]>) WEFT_HD constexpr Span(Span<U> other) noexcept
      : data_(other.data()), size_(other.size()) {}
  /// From any container with data() and size(), such as std::vector.
  template <class Container>
  requires(std::is_convertible_v<
           std::remove_pointer_t<decltype(std::declval<Container&>().data())> (*)[],
           T (*)[]>) constexpr Span(Container& c) noexcept
      : data_(c.data()), size_(c.size()) {}

  WEFT_HD constexpr T& operator[](std::size_t i) const noexcept {
    WEFT_ASSERT(i < size_);
    return data_[i];
  }
  WEFT_HD constexpr T* data() const noexcept { return data_; }
  WEFT_HD constexpr std::size_t size() const noexcept { return size_; }
  WEFT_HD constexpr bool empty() const noexcept { return size_ == 0; }
  WEFT_HD constexpr T* begin() const noexcept { return data_; }
  WEFT_HD constexpr T* end() const noexcept { return data_ + size_; }
  WEFT_HD constexpr Span subspan(std::size_t first, std::size_t count) const noexcept {
    WEFT_ASSERT(first + count <= size_);
    return {data_ + first, count};
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace weft
