#pragma once

#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "weft/core/vec.hpp"

namespace weft::app {

using Json = nlohmann::ordered_json;

/// Writes fields into a JSON object, or reads them from there, so that a list of fields stands in
/// one place: for a struct T, `fields(JsonArchive&, T&)`. JSON has no NaN and no infinity, and
/// holds null instead. A field that is not there keeps its value when it is read: files of earlier
/// versions lack some.
class JsonArchive {
 public:
  enum class Way { write, read };
  JsonArchive(Json& json, Way way) : json_(json), writes_(way == Way::write) {}

  /// A number, a text, a place, an enumerator that describe() names, or a struct of such fields.
  /// @throws Json::exception if something else is read; so do the others
  template <class T>
  void operator()(const char* key, T& value) {
    if (writes_)
      write(json_[key], value);
    else if (json_.contains(key))
      read(json_[key], value);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& value) {
    if (writes_ ? value.has_value() : json_.contains(key))
      (*this)(key, writes_ ? *value : value.emplace());
  }
  /// @param there whether it is written
  template <class T>
  void only_if(bool there, const char* key, T& value) {
    if (there || !writes_) (*this)(key, value);
  }
  /// @param known else it is null, and not read
  void if_known(bool known, const char* key, double& value) {
    if (known)
      (*this)(key, value);
    else if (writes_)
      json_[key] = nullptr;
  }
  /// @param seconds are written as ms
  void ms(const char* key, double& seconds) {
    double value = seconds * 1e3;
    (*this)(key, value);
    if (!writes_) seconds = value / 1e3;
  }
  /// What follows from the other fields.
  void derived(const char* key, double value) {
    if (writes_) json_[key] = value;
  }

 private:
  template <class T>
  void write(Json& to, T& value) {
    if constexpr (std::is_enum_v<T>)
      to = describe(value);
    else if constexpr (std::is_same_v<T, Vec3<double>>)
      to = {value[0], value[1], value[2]};
    else if constexpr (std::is_constructible_v<Json, T>)
      to = value;
    else
      struct_fields(to, value, Way::write);
  }
  template <class T>
  void read(Json& from, T& value) {
    if constexpr (std::is_enum_v<T>)
      value = named<T>(from.get<std::string>());
    else if constexpr (std::is_same_v<T, double>)
      value = from.is_null() ? std::nan("") : from.get<double>();
    else if constexpr (std::is_same_v<T, Vec3<double>>)
      value = {from.at(0).get<double>(), from.at(1).get<double>(), from.at(2).get<double>()};
    else if constexpr (std::is_constructible_v<Json, T>)
      value = from.get<T>();
    else
      struct_fields(from, value, Way::read);
  }
  template <class T>
  static void struct_fields(Json& json, T& value, Way way) {
    JsonArchive own(json, way);
    fields(own, value);
  }
  template <class T>
  static T named(const std::string& name) {
    // describe() calls what comes after the last enumerator "unknown".
    const auto name_of = [](int k) { return std::string_view(describe(static_cast<T>(k))); };
    for (int k = 0; name_of(k) != "unknown"; ++k)
      if (name == name_of(k)) return static_cast<T>(k);
    throw Json::other_error::create(501, "no such value: " + name, nullptr);
  }

  Json& json_;
  bool writes_;
};

template <class T>
Json json_of(T value) {
  Json json;
  JsonArchive writer(json, JsonArchive::Way::write);
  fields(writer, value);
  return json;
}

/// @param required keys
/// @throws Json::exception if one of these is missing, or a field is something else
template <class T>
T read_fields(Json json, std::initializer_list<const char*> required) {
  for (const char* key : required) static_cast<void>(json.at(key));
  T value{};
  JsonArchive reader(json, JsonArchive::Way::read);
  fields(reader, value);
  return value;
}

}  // namespace weft::app
