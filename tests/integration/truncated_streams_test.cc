// Streams that end inside a message, as raw HTTP/2. gRPC 1.51 drops the part that came and reports a half-close as any
// other, so that the server must know by itself when the cloud is complete.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "server/rpc/error_reasons.h"
#include "tests/integration/clouds.h"
#include "tests/integration/raw_http2_call.h"
#include "tests/integration/test_server.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr char kOk[] = "0", kInvalidArgument[] = "3";

enum class End { kData, kEmptyData, kTrailers };

// Where the second message is cut off, as bytes of it that are sent: inside its prefix, behind it, inside the message.
struct Cut {
  const char* name;
  size_t bytes;
  End end;
};

constexpr Cut kCuts[] = {
    {"InPrefix", 2, End::kData},
    {"BehindPrefix", 5, End::kData},
    {"InMessage", 1'000, End::kData},
    {"OneByteShort", 0, End::kData},  // all but one byte
    {"InMessageThenEmptyFrame", 1'000, End::kEmptyData},
    {"InPrefixThenTrailers", 2, End::kTrailers},
    {"InMessageThenTrailers", 1'000, End::kTrailers},
};

class TruncatedStreamsTest : public ::testing::TestWithParam<Cut> {
 protected:
  ~TruncatedStreamsTest() override { server_.WaitUntilIdle(); }

  v1::EstimateCurvatureRequest Chunk(size_t first, size_t count, bool is_last = false) const {
    v1::EstimateCurvatureRequest request;
    request.mutable_chunk()->set_first_index(first);
    request.mutable_chunk()->set_positions(cloud_.PackedPositions(first, count));
    request.mutable_chunk()->set_normals(cloud_.PackedNormals(first, count));
    request.mutable_chunk()->set_is_last(is_last);
    return request;
  }

  // Sends `header`, half of the cloud, and the part of the other half that the parameter tells.
  RawHttp2Result CutOff(const v1::CloudHeader& header) {
    RawHttp2Call call(server_.server().port());
    v1::EstimateCurvatureRequest first;
    *first.mutable_header() = header;
    call.SendBytes(RawHttp2Call::Framed(first));
    call.SendBytes(RawHttp2Call::Framed(Chunk(0, 200)));
    const std::string second = RawHttp2Call::Framed(Chunk(200, 200, header.marks_last_chunk()));
    const Cut& cut = GetParam();
    call.SendBytes(second.substr(0, cut.bytes == 0 ? second.size() - 1 : cut.bytes), cut.end == End::kData);
    if (cut.end == End::kEmptyData) call.SendBytes("", true);
    if (cut.end == End::kTrailers) call.SendTrailers();
    return call.Finish();
  }

  // A call is counted once its status is on its way.
  void WaitForFailure(const char* reason) const {
    server_.WaitForMetric(absl::StrCat("curvd_failures_total{reason=\"", reason, "\"}"), 1);
  }

  TestServer server_;
  const TestCloud cloud_ = Sphere(400, 1.0f);
};

TEST_P(TruncatedStreamsTest, AreAnErrorWhereTheNumberOfPointsIsKnown) {
  v1::CloudHeader header;
  header.set_point_count(400);
  const RawHttp2Result result = CutOff(header);
  EXPECT_EQ(result.grpc_status, kInvalidArgument);
  WaitForFailure(kReasonPointCountMismatch);
  for (const auto& response : result.responses) EXPECT_FALSE(response.has_summary());
}

TEST_P(TruncatedStreamsTest, AreAnErrorWhereTheLastChunkIsMarked) {
  v1::CloudHeader header;
  header.set_marks_last_chunk(true);
  const RawHttp2Result result = CutOff(header);
  EXPECT_EQ(result.grpc_status, kInvalidArgument);
  WaitForFailure(kReasonCloudIncomplete);
  for (const auto& response : result.responses) EXPECT_FALSE(response.has_summary());
}

// What gRPC does not tell, nobody can know: this is the limit that the contract speaks of. If it fails, gRPC has
// learned to tell, and the contract may promise more.
TEST_P(TruncatedStreamsTest, SeemCompleteWhereTheHeaderTellsNothing) {
  const RawHttp2Result result = CutOff({});
  EXPECT_EQ(result.grpc_status, kOk);
  ASSERT_TRUE(!result.responses.empty() && result.responses.back().has_summary());
  EXPECT_EQ(result.responses.back().summary().point_count(), 200u);
}

INSTANTIATE_TEST_SUITE_P(Cuts, TruncatedStreamsTest, ::testing::ValuesIn(kCuts),
                         [](const auto& cut) { return std::string(cut.param.name); });

using WholeStreamsTest = TruncatedStreamsTest;

TEST_P(WholeStreamsTest, AreAnsweredWhereTheLastChunkIsMarked) {
  v1::EstimateCurvatureRequest header;
  header.mutable_header()->set_marks_last_chunk(true);
  RawHttp2Call call(server_.server().port());
  call.SendBytes(RawHttp2Call::Framed(header));
  call.SendBytes(RawHttp2Call::Framed(Chunk(0, 200)));
  call.SendBytes(RawHttp2Call::Framed(Chunk(200, 200, true)), GetParam().end == End::kData);
  if (GetParam().end == End::kTrailers) call.SendTrailers();
  const RawHttp2Result result = call.Finish();
  EXPECT_EQ(result.grpc_status, kOk);
  ASSERT_TRUE(!result.responses.empty() && result.responses.back().has_summary());
  EXPECT_EQ(result.responses.back().summary().point_count(), 400u);
}

INSTANTIATE_TEST_SUITE_P(Ends, WholeStreamsTest,
                         ::testing::Values(Cut{"WithData", 0, End::kData}, Cut{"WithTrailers", 0, End::kTrailers}),
                         [](const auto& cut) { return std::string(cut.param.name); });

}  // namespace
}  // namespace curvd
