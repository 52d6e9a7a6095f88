#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/input/quantity.hpp"
#include "weft/core/vec.hpp"

/// Strict reading of JSON: every key must be known, every value of its type, and what is read or
/// defaulted is written down again, so that the resolved document comes out of the same pass.
namespace weft::io {

/// Parses JSON with `//` comments.
/// @param text bytes of the file
/// @param file for messages
/// @throws SceneError with line and column; also for a key given twice and for absurd nesting
nlohmann::json parse_json(std::string_view text, const std::string& file);

/// Value as one short line for a message.
std::string short_text(const nlohmann::json& value);

/// One object of the document. Getters without a fallback require the key. Each getter throws
/// SceneError with file, path, value and what is allowed, and records what it returns in `out`.
class Fields {
 public:
  /// @param in   the object as the user wrote it; must outlive this
  /// @param out  becomes an object with every key that was read; must outlive this
  /// @param file for messages
  /// @param path of the object, empty for the root
  /// @param keys all keys that may stand here; empty: any
  /// @throws SceneError if `in` is no object or holds an unknown key
  Fields(const nlohmann::json& in, nlohmann::json& out, const std::string& file, std::string path,
         std::vector<std::string> keys);

  bool has(const std::string& key) const { return in_->contains(key); }
  bool is_text(const std::string& key) const { return has(key) && in_->at(key).is_string(); }
  bool is_null(const std::string& key) const { return has(key) && in_->at(key).is_null(); }
  bool is_object(const std::string& key) const { return has(key) && in_->at(key).is_object(); }
  std::vector<std::string> present_keys() const;
  const std::string& file() const { return *file_; }
  std::string path_of(const std::string& key) const;

  double number(const std::string& key, std::optional<double> fallback = {});
  /// A number, or null or nothing for "none".
  std::optional<double> number_or_null(const std::string& key);
  /// Number > 0.
  double positive(const std::string& key, std::optional<double> fallback = {});
  /// Number in the range of its kind.
  double number(const std::string& key, const Quantity& kind, std::optional<double> fallback = {});
  /// Whole number from low to high; 2e4 counts as one.
  std::int64_t integer(const std::string& key, std::optional<std::int64_t> fallback,
                       std::int64_t low, std::int64_t high);
  bool boolean(const std::string& key, bool fallback);
  std::string text(const std::string& key, std::optional<std::string> fallback = {});
  /// A word of letters, digits, _ and -, as names of cloths must be.
  std::string name(const std::string& key, const std::string& fallback);
  /// @return number of the word in `words`
  std::size_t choice(const std::string& key, const std::vector<std::string>& words,
                     std::optional<std::size_t> fallback);
  std::vector<std::size_t> choices(const std::string& key, const std::vector<std::string>& words);
  std::vector<std::int64_t> integers(const std::string& key, std::int64_t low, std::int64_t high,
                                     std::optional<std::size_t> count);
  /// Lists of whole numbers from low to high in a list.
  /// @param count how many such lists, each how many numbers in one; nothing: any
  std::vector<std::vector<std::int64_t>> integer_lists(const std::string& key, std::int64_t low,
                                                       std::int64_t high,
                                                       std::optional<std::size_t> count,
                                                       std::optional<std::size_t> each);
  /// Lists of finite numbers in a list, each of `low` to `high` numbers.
  std::vector<std::vector<double>> number_lists(const std::string& key, std::size_t low,
                                                std::size_t high);
  /// List of so many texts.
  std::vector<std::string> texts(const std::string& key, std::size_t count);
  template <int N>
  Vec<double, N> vector(const std::string& key, std::optional<Vec<double, N>> fallback = {}) {
    std::optional<std::vector<double>> list;
    if (fallback) list.emplace(fallback->e, fallback->e + N);
    const std::vector<double> values = numbers(key, N, std::move(list));
    Vec<double, N> result{};
    for (int k = 0; k < N; ++k) result[k] = values[static_cast<std::size_t>(k)];
    return result;
  }
  /// Vector whose components are all in the range of their kind.
  template <int N>
  Vec<double, N> vector(const std::string& key, const Quantity& kind,
                        std::optional<Vec<double, N>> fallback = {}) {
    const Vec<double, N> result = vector<N>(key, std::move(fallback));
    for (int k = 0; k < N; ++k)
      if (!kind.holds(result[k])) refuse(key, "each " + kind.allowed());
    return result;
  }
  /// Unit vector along a vector of any length but 0.
  Vec3<double> direction(const std::string& key, const Vec3<double>& fallback);
  /// Object under `key`; an empty one if it is absent.
  Fields object(const std::string& key, std::vector<std::string> keys);
  /// List of objects under `key`; empty if it is absent.
  std::vector<Fields> objects(const std::string& key, const std::vector<std::string>& keys);
  /// Which one of the keys is there.
  /// @throws SceneError if none or several are
  std::string one_of(const std::vector<std::string>& keys) const;

  /// Text of what was read or defaulted.
  std::string shown(const std::string& key) const { return short_text(out_->at(key)); }

  /// Writes a value that was worked out, not read, into the resolved document.
  void record(const std::string& key, nlohmann::json value) { (*out_)[key] = std::move(value); }

  /// Leaves out of the resolved document what was read under a key.
  void leave_out(const std::string& key) { out_->erase(key); }

  /// @throws SceneError always, with the value as the user wrote it
  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const;
  [[noreturn]] void refuse(const std::string& key, const std::string& value,
                           const std::string& allowed) const;

 private:
  std::vector<double> numbers(const std::string& key, std::size_t count,
                              std::optional<std::vector<double>> fallback);
  const nlohmann::json* find(const std::string& key) const;
  const nlohmann::json& require(const std::string& key, const std::string& allowed) const;

  const nlohmann::json* in_;
  nlohmann::json* out_;
  const std::string* file_;
  std::string path_;
};

}  // namespace weft::io
