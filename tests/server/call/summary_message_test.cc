#include "server/call/summary_message.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

TEST(FillSummaryTest, TellsWhatTheRecordHolds) {
  CallRecord record;
  record.points_received = 21;
  record.status_counts = {0, 1, 2, 3, 4, 5, 6};
  record.normals_rescaled = 6;
  record.peak_bytes = 7;
  record.seconds = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  curvature::v1::Summary summary;
  FillSummary(record, &summary);
  EXPECT_EQ(summary.point_count(), 21u);
  EXPECT_EQ(summary.status_counts().ok(), 1u);
  EXPECT_EQ(summary.status_counts().too_few_neighbors(), 2u);
  EXPECT_EQ(summary.status_counts().degenerate_area(), 3u);
  EXPECT_EQ(summary.status_counts().invalid_input(), 4u);
  EXPECT_EQ(summary.status_counts().inconsistent_normals(), 5u);
  EXPECT_EQ(summary.status_counts().singular_fit(), 6u);
  EXPECT_EQ(summary.normals_rescaled(), 6u);
  EXPECT_EQ(summary.peak_bytes(), 7u);
  EXPECT_EQ(summary.seconds().receive(), 0.1);
  EXPECT_EQ(summary.seconds().queue(), 0.3);
  EXPECT_EQ(summary.seconds().index(), 0.4);
  EXPECT_EQ(summary.seconds().estimate(), 0.5);
  EXPECT_EQ(summary.seconds().send(), 0.6);
}

}  // namespace
}  // namespace curvd
