// Writes numbers into messages, so that one which is out of its range never looks like the bound.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace curvd {

// Returns `value` with six digits where these read back as the same number, else with the fewest that do: "0.1",
// "1.0000001", "nan", "-inf", whatever the locale.
template <typename Scalar>
std::string NumberText(Scalar value) {
  if (std::isnan(value)) return "nan";
  char text[32];
  char* const room_end = text + sizeof(text);
  const std::to_chars_result six = std::to_chars(text, room_end, value, std::chars_format::general, 6);
  Scalar read = 0;
  std::from_chars(text, six.ptr, read);
  const bool is_same = std::isinf(value) || read == value;
  return {text, is_same ? six.ptr : std::to_chars(text, room_end, value).ptr};
}

// Returns "(x, y, z)", each as NumberText writes it.
template <typename Scalar>
std::string VectorText(const std::array<Scalar, 3>& v) {
  std::string text;
  for (const Scalar number : v) text.append(text.empty() ? "(" : ", ").append(NumberText(number));
  return text.append(")");
}

}  // namespace curvd
