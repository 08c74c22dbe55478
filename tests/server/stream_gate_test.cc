#include "server/stream_gate.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "server/reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

class FakeStream : public OpenStream {
 public:
  void Tick(std::chrono::steady_clock::time_point) override {}
  void Abort(absl::Status) override {}
};

TEST(StreamGateTest, CountsOpenStreams) {
  StreamGate gate(2);
  const auto stream = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(stream).ok());
  EXPECT_EQ(gate.open_count(), 1u);
  EXPECT_EQ(gate.open_streams().size(), 1u);
  gate.Close(stream.get());
  gate.Close(stream.get());
  EXPECT_EQ(gate.open_count(), 0u);
}

TEST(StreamGateTest, RefusesOneStreamTooMany) {
  StreamGate gate(1);
  const auto first = std::make_shared<FakeStream>();
  const auto second = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(first).ok());
  const absl::Status refusal = gate.Open(second);
  EXPECT_TRUE(IsError(refusal, absl::StatusCode::kResourceExhausted, kReasonStreamLimit, {"1", "max_streams"}));
  EXPECT_TRUE(refusal.GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());
  gate.Close(first.get());
  EXPECT_TRUE(gate.Open(second).ok());
}

TEST(StreamGateTest, TakesNobodyWhileDraining) {
  StreamGate gate(1);
  gate.StartDraining();
  EXPECT_TRUE(gate.draining());
  EXPECT_TRUE(IsError(gate.Open(std::make_shared<FakeStream>()), absl::StatusCode::kUnavailable, kReasonDraining,
                      {"draining", "another replica"}));
}

TEST(StreamGateTest, WaitsUntilTheLastStreamHasClosed) {
  StreamGate gate(1);
  const auto stream = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(stream).ok());
  EXPECT_FALSE(gate.WaitUntilEmpty(absl::Milliseconds(1)));
  std::thread closer([&] { gate.Close(stream.get()); });
  EXPECT_TRUE(gate.WaitUntilEmpty(absl::InfiniteDuration()));
  closer.join();
}

}  // namespace
}  // namespace curvd
