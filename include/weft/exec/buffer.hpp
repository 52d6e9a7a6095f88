#pragma once

#include <algorithm>
#include <type_traits>
#include <utility>

#include "weft/core/span.hpp"
#include "weft/exec/device.hpp"

namespace weft {

/// Array in the memory of one device. Grows, never shrinks. The caller sees to it that no queue
/// still uses the array when it is resized, moved or destroyed. Counted under the MemoryName in
/// force where it was made.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(Device& device) : device_(&device), name_(MemoryName::current()) {}
  Buffer(Device& device, std::size_t size) : Buffer(device) { resize(size); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { release(); }

  /// Sets the size; the contents are lost if it exceeds the capacity.
  /// @throws DeviceError if there is not enough memory, std::bad_alloc if it cannot be counted; the
  ///         buffer is then empty
  void resize(std::size_t size) {
    if (size > capacity_) {
      release();
      void* memory = device_->allocate(size * sizeof(T));
      try {
        device_->memory().add(name_, size * sizeof(T));
      } catch (...) {
        device_->release(memory, size * sizeof(T));
        throw;
      }
      data_ = static_cast<T*>(memory);
      capacity_ = size;
    }
    size_ = size;
  }
  /// As resize, with a quarter to spare, for arrays whose size changes from step to step.
  void grow(std::size_t size) {
    if (size > capacity_) resize(size + size / 4 + 64);
    size_ = std::max(size_, size);
  }

  T* data() const noexcept { return data_; }
  std::size_t size() const noexcept { return size_; }
  std::size_t capacity() const noexcept { return capacity_; }
  Span<T> span() const noexcept { return {data_, size_}; }
  Device& device() const noexcept { return *device_; }

 private:
  void release() noexcept {
    if (data_ == nullptr) return;
    device_->release(data_, capacity_ * sizeof(T));
    device_->memory().remove(name_, capacity_ * sizeof(T));
    data_ = nullptr;
    size_ = capacity_ = 0;
  }
  void swap(Buffer& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(name_, other.name_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  Device* device_ = nullptr;
  const char* name_ = "other";
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace weft
