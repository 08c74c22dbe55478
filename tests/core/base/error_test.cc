#include "core/base/error.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

TEST(Error, KeepsItsKindAndHasTheCodeThatGoesWithIt) {
  const struct {
    ErrorKind kind;
    absl::StatusCode code;
  } kCases[] = {
      {ErrorKind::kInvalid, absl::StatusCode::kInvalidArgument},
      {ErrorKind::kOutOfMemory, absl::StatusCode::kResourceExhausted},
      {ErrorKind::kNeighborhoodTooLarge, absl::StatusCode::kResourceExhausted},
      {ErrorKind::kCancelled, absl::StatusCode::kCancelled},
      {ErrorKind::kOther, absl::StatusCode::kInternal},
  };
  for (const auto& [kind, code] : kCases) {
    const absl::Status status = MakeCoreError(kind, "a reason");
    EXPECT_EQ(status.code(), code);
    EXPECT_EQ(status.message(), "a reason");
    EXPECT_EQ(KindOf(status), kind);
  }
}

TEST(Error, OfSomebodyElseHasNoKindOfOurs) {
  EXPECT_EQ(KindOf(absl::ResourceExhaustedError("out of memory")), ErrorKind::kOther);
}

}  // namespace
}  // namespace curvd
