#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace weft::io {

/// Makes a document out of what a parser of JSON reports, for json::sax_parse(). Time grows with
/// the size of the text; nlohmann-json's own parser with a callback walks through all siblings of
/// each object that ends.
class JsonDocument {
 public:
  using json = nlohmann::json;

  /// @param file for messages; kept by reference
  explicit JsonDocument(const std::string& file) : file_(file) {}

  json take() { return std::move(root_); }

  bool null();
  bool boolean(bool value);
  bool number_integer(json::number_integer_t value);
  bool number_unsigned(json::number_unsigned_t value);
  bool number_float(json::number_float_t value, const std::string& text);
  bool string(std::string& value);
  bool binary(json::binary_t& value);
  bool start_object(std::size_t size);
  /// @throws SceneError if the object has the key already
  bool key(std::string& value);
  bool end_object();
  bool start_array(std::size_t size);
  bool end_array();
  /// @throws json::exception, the error itself
  bool parse_error(std::size_t position, const std::string& token, const json::exception& error);

 private:
  json& put(json value);
  void open(json value);

  const std::string& file_;
  json root_;
  std::vector<json*> open_;  ///< objects and lists around the next value
  json* slot_ = nullptr;     ///< of the last key
};

}  // namespace weft::io
