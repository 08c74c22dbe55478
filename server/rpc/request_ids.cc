#include "server/rpc/request_ids.h"

#include <cstdint>

#include "absl/random/random.h"
#include "absl/strings/str_cat.h"

namespace curvd {

RequestIds::RequestIds() {
  absl::BitGen bits;
  prefix_ = absl::StrCat(absl::Hex(absl::Uniform<uint32_t>(bits), absl::kZeroPad8));
}

std::string RequestIds::Next() { return absl::StrCat(prefix_, "-", count_.fetch_add(1) + 1); }

}  // namespace curvd
