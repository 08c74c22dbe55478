#include "server/admission/stream_gate.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

class FakeStream : public OpenStream {
 public:
  void Tick(std::chrono::steady_clock::time_point) override {}
  void Abort(absl::Status status) override { end = std::move(status); }

  absl::Status end;
};

Caller CallerNamed(const std::string& name, uint32_t max_streams = 0) {
  Caller caller;
  caller.name = name;
  caller.max_streams = max_streams;
  return caller;
}

const Caller kAnybody = CallerNamed("10.0.0.7");

TEST(StreamGateTest, CountsOpenStreams) {
  StreamGate gate(2, 10);
  const auto stream = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(stream, kAnybody).ok());
  EXPECT_EQ(gate.open_count(), 1u);
  EXPECT_EQ(gate.open_streams().size(), 1u);
  gate.Close(stream.get());
  gate.Close(stream.get());
  EXPECT_EQ(gate.open_count(), 0u);
}

TEST(StreamGateTest, RefusesOneStreamTooMany) {
  StreamGate gate(1, 10);
  const auto first = std::make_shared<FakeStream>();
  const auto second = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(first, kAnybody).ok());
  const absl::Status refusal = gate.Open(second, kAnybody);
  EXPECT_TRUE(IsError(refusal, absl::StatusCode::kResourceExhausted, kReasonStreamLimit, {"1", "max_streams"}));
  EXPECT_TRUE(refusal.GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());
  gate.Close(first.get());
  EXPECT_TRUE(gate.Open(second, kAnybody).ok());
}

TEST(StreamGateTest, KeepsRoomForOthers) {
  StreamGate gate(10, 2);
  const auto first = std::make_shared<FakeStream>();
  const auto second = std::make_shared<FakeStream>();
  const auto third = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(first, CallerNamed("alice")).ok());
  ASSERT_TRUE(gate.Open(second, CallerNamed("alice")).ok());
  const absl::Status refusal = gate.Open(third, CallerNamed("alice"));
  EXPECT_TRUE(IsError(refusal, absl::StatusCode::kResourceExhausted, kReasonPeerStreamLimit,
                      {"alice", "2", "max_streams_per_peer"}));
  EXPECT_TRUE(refusal.GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());
  EXPECT_TRUE(gate.Open(third, CallerNamed("bob")).ok());
  gate.Close(first.get());
  EXPECT_TRUE(gate.Open(first, CallerNamed("alice")).ok());
}

TEST(StreamGateTest, CallersWhoTakeAllTheyCanGetShareAlikeAndLeavePlacesForOthers) {
  StreamGate gate(100, 100);
  std::vector<std::shared_ptr<FakeStream>> streams;
  const auto opens = [&](const std::string& name) {
    streams.push_back(std::make_shared<FakeStream>());
    return gate.Open(streams.back(), CallerNamed(name));
  };
  int alice = 0, bob = 0;
  absl::Status refusal;
  while (refusal.ok()) {
    refusal = opens("alice");
    alice += refusal.ok();
    if (refusal.ok()) refusal = opens("bob");
    bob += refusal.ok();
  }
  EXPECT_TRUE(
      IsError(refusal, absl::StatusCode::kResourceExhausted, kReasonPeerStreamLimit, {"max_streams", "others"}));
  EXPECT_NEAR(alice, bob, 1);
  EXPECT_NEAR(alice + bob, 94, 1);
  EXPECT_TRUE(opens("carol").ok());
}

TEST(StreamGateTest, ACallerAloneMayTakeEveryPlace) {
  StreamGate gate(20, 20);
  std::vector<std::shared_ptr<FakeStream>> streams;
  for (int i = 0; i < 20; ++i) {
    streams.push_back(std::make_shared<FakeStream>());
    EXPECT_TRUE(gate.Open(streams.back(), kAnybody).ok()) << i;
  }
}

TEST(StreamGateTest, ACallThatEndsMakesRoomForTheNextOfItsCaller) {
  StreamGate gate(10, 1);
  const auto first = std::make_shared<FakeStream>();
  const auto second = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(first, CallerNamed("alice")).ok());
  gate.FreePlace(first.get());
  gate.FreePlace(first.get());
  EXPECT_TRUE(gate.Open(second, CallerNamed("alice")).ok());
  EXPECT_EQ(gate.open_count(), 2u);
  gate.Close(first.get());
  EXPECT_FALSE(gate.Open(first, CallerNamed("alice")).ok());
}

TEST(StreamGateTest, ACallersOwnLimitGoesBeforeThatOfPeers) {
  StreamGate gate(10, 2);
  const auto first = std::make_shared<FakeStream>();
  const auto second = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(first, CallerNamed("alice", 1)).ok());
  EXPECT_TRUE(IsError(gate.Open(second, CallerNamed("alice", 1)), absl::StatusCode::kResourceExhausted,
                      kReasonPeerStreamLimit, {"below 1"}));
}

TEST(StreamGateTest, EndsTheCallsOfThoseWhoMayNoLonger) {
  StreamGate gate(10, 10);
  const auto revoked = std::make_shared<FakeStream>();
  const auto other = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(revoked, CallerNamed("alice")).ok());
  ASSERT_TRUE(gate.Open(other, CallerNamed("bob")).ok());
  gate.EndWhere([](const Caller& caller) {
    return caller.name == "alice" ? absl::UnauthenticatedError("revoked") : absl::OkStatus();
  });
  EXPECT_EQ(revoked->end.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_TRUE(other->end.ok());
}

TEST(StreamGateTest, TakesNobodyWhileDraining) {
  StreamGate gate(1, 10);
  gate.StartDraining();
  EXPECT_TRUE(gate.draining());
  EXPECT_TRUE(IsError(gate.Open(std::make_shared<FakeStream>(), kAnybody), absl::StatusCode::kUnavailable,
                      kReasonDraining, {"draining", "another replica"}));
}

TEST(StreamGateTest, WaitsUntilTheLastStreamHasClosed) {
  StreamGate gate(1, 10);
  const auto stream = std::make_shared<FakeStream>();
  ASSERT_TRUE(gate.Open(stream, kAnybody).ok());
  EXPECT_FALSE(gate.WaitUntilEmpty(absl::Milliseconds(1)));
  std::thread closer([&] { gate.Close(stream.get()); });
  EXPECT_TRUE(gate.WaitUntilEmpty(absl::InfiniteDuration()));
  closer.join();
}

}  // namespace
}  // namespace curvd
