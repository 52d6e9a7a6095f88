#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "weft/error.hpp"

namespace weft {

/// Values one after the other, as they lie in memory; of a list, first how many.
class Packer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::is_trivially_copyable_v<T>)
      bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    else
      for (const T& value : values) put(value);
  }
  std::string bytes;
};

/// Reads what a Packer has written.
class Unpacker {
 public:
  /// @param bytes   must outlive this
  /// @param file    for messages
  /// @param field   the same
  /// @param allowed the same
  Unpacker(const std::string& bytes, std::string file, std::string field, std::string allowed)
      : bytes_(bytes),
        file_(std::move(file)),
        field_(std::move(field)),
        allowed_(std::move(allowed)) {}

  /// @throws SceneError if there are not as many bytes; so does the next
  template <class T>
  void get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (bytes_.size() - position_ < sizeof value) refuse("is truncated");
    std::memcpy(&value, bytes_.data() + position_, sizeof value);
    position_ += sizeof value;
  }
  template <class T>
  void get(std::vector<T>& values) {
    constexpr bool plain = std::is_trivially_copyable_v<T>;
    std::uint64_t count = 0;
    get(count);
    if (count > (bytes_.size() - position_) / (plain ? sizeof(T) : sizeof count))
      refuse("is truncated");
    values.resize(count);
    for (T& value : values) get(value);
  }
  void end() const {
    if (position_ != bytes_.size()) refuse("has bytes after its end");
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw SceneError(file_, field_, what, allowed_);
  }

 private:
  const std::string& bytes_;
  std::string file_;
  std::string field_;
  std::string allowed_;
  std::size_t position_ = 0;
};

}  // namespace weft
