#include "host/input/quantity.hpp"

#include "host/input/checker.hpp"

namespace weft {

std::string short_number(double value) {
  std::string text = text_of(value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  std::size_t digits = e + 1;
  if (text[digits] == '+') text.erase(digits, 1);
  if (text[digits] == '-') ++digits;
  while (digits + 1 < text.size() && text[digits] == '0') text.erase(digits, 1);
  return text;
}

std::string Quantity::allowed() const {
  std::string text = or_zero ? "0, or " : "";
  text += std::string(noun) + " from " + short_number(least) + " to " + short_number(most);
  return *unit == '\0' ? text : text + " " + unit;
}

}  // namespace weft
