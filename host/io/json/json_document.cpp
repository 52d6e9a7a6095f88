#include "host/io/json/json_document.hpp"

#include <utility>

#include "host/io/json/json_fields.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

constexpr std::size_t max_depth = 32;

}  // namespace

JsonDocument::json& JsonDocument::put(json value) {
  if (open_.empty()) return root_ = std::move(value);
  if (open_.back()->is_array()) {
    open_.back()->push_back(std::move(value));
    return open_.back()->back();
  }
  return *slot_ = std::move(value);
}

void JsonDocument::open(json value) {
  if (open_.size() > max_depth)
    throw SceneError(file_ + ": nested more than " + std::to_string(max_depth) + " deep");
  // The place stays where it is: a list grows only once its last entry is complete.
  open_.push_back(&put(std::move(value)));
}

bool JsonDocument::null() {
  put(nullptr);
  return true;
}

bool JsonDocument::boolean(bool value) {
  put(value);
  return true;
}

bool JsonDocument::number_integer(json::number_integer_t value) {
  put(value);
  return true;
}

bool JsonDocument::number_unsigned(json::number_unsigned_t value) {
  put(value);
  return true;
}

bool JsonDocument::number_float(json::number_float_t value, const std::string&) {
  put(value);
  return true;
}

bool JsonDocument::string(std::string& value) {
  put(std::move(value));
  return true;
}

bool JsonDocument::binary(json::binary_t&) {
  return false;  // no text has any
}

bool JsonDocument::start_object(std::size_t) {
  open(json::object());
  return true;
}

bool JsonDocument::key(std::string& value) {
  const auto [entry, is_new] =
      open_.back()->get_ref<json::object_t&>().try_emplace(std::move(value), nullptr);
  if (!is_new)
    throw SceneError(file_, short_text(entry->first), "given twice", "each key once per object");
  slot_ = &entry->second;
  return true;
}

bool JsonDocument::end_object() {
  open_.pop_back();
  return true;
}

bool JsonDocument::start_array(std::size_t) {
  open(json::array());
  return true;
}

bool JsonDocument::end_array() {
  open_.pop_back();
  return true;
}

bool JsonDocument::parse_error(std::size_t, const std::string&, const json::exception& error) {
  if (const auto* out_of_range = dynamic_cast<const json::out_of_range*>(&error))
    throw json::out_of_range(*out_of_range);
  throw json::parse_error(dynamic_cast<const json::parse_error&>(error));
}

}  // namespace weft::io
