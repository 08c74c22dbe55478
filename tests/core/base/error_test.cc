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
  EXPECT_EQ(SubjectOf(absl::ResourceExhaustedError("out of memory")).field, "");
}

TEST(Error, KeepsWhatItIsAbout) {
  const ErrorSubject subject = SubjectOf(MakeCoreError(ErrorKind::kRepeatedId, "twins", {"ids", "5", "another", "7"}));
  EXPECT_EQ(subject.field, "ids");
  EXPECT_EQ(subject.value, "5");
  EXPECT_EQ(subject.limit, "another");
  EXPECT_EQ(subject.point, "7");
}

TEST(InvalidValueTest, SaysAllOfItsSubject) {
  const absl::Status status = InvalidValue("radius", "0", "above 0");
  EXPECT_EQ(KindOf(status), ErrorKind::kInvalid);
  EXPECT_EQ(status.message(), "radius is 0; it must be above 0");
  EXPECT_EQ(SubjectOf(status).field, "radius");
  EXPECT_EQ(SubjectOf(status).limit, "above 0");
}

}  // namespace
}  // namespace curvd
