#include "core/cloud/invalid_point.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace curvd {
namespace {

TEST(InvalidPointTest, NamesPointValueLimitAndRemedies) {
  const absl::Status status = InvalidPoint("normal", 7, "(0, 0, 0)", "not zero");
  EXPECT_EQ(KindOf(status), ErrorKind::kInvalid);
  EXPECT_EQ(status.message(),
            "normal of point 7 is (0, 0, 0); it must be not zero; mend the point, or have such points skipped "
            "(invalid_point_policy SKIP; skip_invalid, skipInvalid in Node.js)");
}

TEST(InvalidPointTest, TellsProgramsTheSame) {
  const ErrorSubject subject = SubjectOf(InvalidPoint("position", 7, "(1, nan, 0)", "finite"));
  EXPECT_EQ(subject.field, "positions");
  EXPECT_EQ(subject.value, "(1, nan, 0)");
  EXPECT_EQ(subject.limit, "finite");
  EXPECT_EQ(subject.point, "7");
}

}  // namespace
}  // namespace curvd
