#include "server/call/response_session.h"

#include <gtest/gtest.h>

namespace curvd {
namespace {

using Kind = ResponseSession::Kind;

TEST(ResponseSessionTest, HasNothingToSayBeforeTheHeader) {
  ResponseSession session;
  EXPECT_EQ(session.Next().kind, Kind::kNothing);
  session.SetProgressDue(true);
  EXPECT_EQ(session.Next().kind, Kind::kNothing);
}

TEST(ResponseSessionTest, AcceptedComesFirstAndOnce) {
  ResponseSession session;
  session.Accept();
  session.SetProgressDue(true);
  EXPECT_EQ(session.Next().kind, Kind::kAccepted);
  EXPECT_EQ(session.Next().kind, Kind::kProgress);
  EXPECT_EQ(session.Next().kind, Kind::kNothing);
}

TEST(ResponseSessionTest, AProgressIsSentOnceForEachTimeThatItIsDue) {
  ResponseSession session;
  session.Accept();
  session.Next();
  session.SetProgressDue(true);
  session.SetProgressDue(true);
  EXPECT_EQ(session.Next().kind, Kind::kProgress);
  EXPECT_EQ(session.Next().kind, Kind::kNothing);
  session.SetProgressDue(true);
  session.SetProgressDue(false);
  EXPECT_EQ(session.Next().kind, Kind::kNothing);
}

TEST(ResponseSessionTest, ResultsCoverTheCloudInOrderThenTheSummary) {
  ResponseSession session;
  session.Accept();
  session.Next();
  session.Complete(25, 10);
  for (const auto& [first, count] : {std::pair(0, 10), std::pair(10, 10), std::pair(20, 5)}) {
    const ResponseSession::Message message = session.Next();
    ASSERT_EQ(message.kind, Kind::kResults);
    EXPECT_EQ(message.first, static_cast<uint64_t>(first));
    EXPECT_EQ(message.count, static_cast<uint64_t>(count));
  }
  EXPECT_EQ(session.Next().kind, Kind::kSummary);
  EXPECT_EQ(session.Next().kind, Kind::kEnd);
  EXPECT_EQ(session.Next().kind, Kind::kEnd);
}

TEST(ResponseSessionTest, EachScaleCoversTheCloudAfterTheOneBefore) {
  ResponseSession session;
  session.Accept();
  session.Next();
  session.Complete(15, 10, 3);
  for (uint64_t scale = 0; scale < 3; ++scale) {
    for (const auto& [first, count] : {std::pair(0, 10), std::pair(10, 5)}) {
      const ResponseSession::Message message = session.Next();
      ASSERT_EQ(message.kind, Kind::kResults);
      EXPECT_EQ(message.scale, scale);
      EXPECT_EQ(message.first, static_cast<uint64_t>(first));
      EXPECT_EQ(message.count, static_cast<uint64_t>(count));
    }
  }
  EXPECT_EQ(session.Next().kind, Kind::kSummary);
  EXPECT_EQ(session.Next().kind, Kind::kEnd);
}

TEST(ResponseSessionTest, TheLastChunkMayBeFull) {
  ResponseSession session;
  session.Accept();
  session.Next();
  session.Complete(10, 10);
  EXPECT_EQ(session.Next().count, 10u);
  EXPECT_EQ(session.Next().kind, Kind::kSummary);
}

TEST(ResponseSessionTest, ACloudWithoutPointsHasASummary) {
  ResponseSession session;
  session.Accept();
  session.Complete(0, 10);
  EXPECT_EQ(session.Next().kind, Kind::kAccepted);
  EXPECT_EQ(session.Next().kind, Kind::kSummary);
  EXPECT_EQ(session.Next().kind, Kind::kEnd);
}

TEST(ResponseSessionTest, NoProgressComesBetweenResults) {
  ResponseSession session;
  session.Accept();
  session.Next();
  session.SetProgressDue(true);
  session.Complete(20, 10);
  EXPECT_EQ(session.Next().kind, Kind::kResults);
  session.SetProgressDue(true);
  EXPECT_EQ(session.Next().kind, Kind::kResults);
  EXPECT_EQ(session.Next().kind, Kind::kSummary);
}

}  // namespace
}  // namespace curvd
