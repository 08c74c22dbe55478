// Where writers put the bytes of a file.
#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace curv {

class ByteSink {
 public:
  virtual ~ByteSink() = default;

  // Takes bytes that follow those of the calls before. INVALID_ARGUMENT saying why they cannot be written; nothing may
  // be appended after that.
  virtual absl::Status Append(std::string_view bytes) = 0;
};

}  // namespace curv
