#include "core/cloud/invalid_point.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/error.h"

namespace curvd {
namespace {

// In the words of the contract and its clients.
constexpr char kOtherRemedy[] =
    ", or have such points skipped (invalid_point_policy SKIP; skip_invalid, skipInvalid in Node.js)";

}  // namespace

absl::Status InvalidPoint(const char* what, size_t point, std::string value, std::string limit, const char* remedy) {
  const std::string message =
      absl::StrCat(what, " of point ", point, " is ", value, "; it must be ", limit, "; ", remedy, kOtherRemedy);
  return MakeCoreError(ErrorKind::kInvalid, message,
                       {absl::StrCat(what, "s"), std::move(value), std::move(limit), absl::StrCat(point)});
}

}  // namespace curvd
