#include "server/request_ids.h"

#include <random>

#include "absl/strings/str_cat.h"

namespace curvd {

RequestIds::RequestIds() : prefix_(absl::StrCat(absl::Hex(std::random_device{}(), absl::kZeroPad8))) {}

std::string RequestIds::Next() { return absl::StrCat(prefix_, "-", count_.fetch_add(1) + 1); }

}  // namespace curvd
