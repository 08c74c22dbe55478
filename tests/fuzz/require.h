// What must hold for every input a fuzzer can make.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace fuzz {

// Ends the process, which is a finding, unless `holds`.
inline void Require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", property);
  std::abort();
}

// Whether `text` can be shown on a terminal as it is: it is not empty, and no byte of the input moves the cursor.
inline bool IsShowable(std::string_view text) {
  for (const char c : text) {
    if (c < ' ' || c > '~') return false;
  }
  return !text.empty();
}

}  // namespace fuzz
