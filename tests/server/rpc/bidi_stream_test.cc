#include "server/rpc/bidi_stream.h"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/rpc/error_reasons.h"
#include "tests/server/rpc/fake_transport.h"
#include "tests/server/rpc/test_service.h"

namespace curvd {
namespace {

using std::chrono::seconds;

constexpr char kHandled[] = "grpc_server_handled_total{grpc_code=\"";
constexpr char kLabels[] =
    "\",grpc_method=\"EstimateCurvature\",grpc_service=\"curvature.v1.CurvatureService\",grpc_type=\"bidi_stream\"}";

// A protocol that keeps what it receives, and sends what it is told to.
class Protocol final : public BidiStream {
 public:
  Protocol(ServiceContext& service, const RpcArrival& arrival, BidiTransport& transport)
      : BidiStream(service, RpcMethod::kEstimateCurvature, arrival, transport) {}

  using BidiStream::End;
  using BidiStream::JudgeWrites;
  using BidiStream::ReadNext;
  using BidiStream::WriteNext;

  std::vector<std::string> received;
  bool reads_on = true;
  bool has_half_closed = false;
  std::deque<std::string> due;
  bool ends_when_written = false;
  std::function<void()> while_making;
  int made = 0;
  int stops = 0;
  std::function<void()> on_stop;
  std::vector<bool> ticks;

 private:
  void Receive(grpc::ByteBuffer& message) override {
    grpc::Slice slice;
    ASSERT_TRUE(message.DumpToSingleSlice(&slice).ok());
    received.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
    if (reads_on) ReadNext();
  }
  void ReceiveEnd() override { has_half_closed = true; }
  Made MakeMessage(grpc::ByteBuffer& message) override {
    if (while_making) std::exchange(while_making, nullptr)();
    if (due.empty()) return ends_when_written ? Made::kLast : Made::kNothing;
    ++made;
    message = ToByteBuffer(due.front());
    due.pop_front();
    return Made::kMessage;
  }
  void OnTick(Clock::time_point, bool is_writing) override { ticks.push_back(is_writing); }
  void Stop() override {
    ++stops;
    if (on_stop) on_stop();
  }
  void CompleteRecord(CallRecord& record) override { record.request_tag = "completed"; }
};

class BidiStreamTest : public ::testing::Test {
 protected:
  void Start(const RpcArrival& arrival = ArrivalFrom("ipv4:10.0.0.7:1234")) {
    stream_ = std::make_shared<Protocol>(service_, arrival, transport_);
    stream_->Start();
  }
  void Send(const std::string& message) {
    stream_->due.push_back(message);
    stream_->WriteNext();
  }
  // What curvd counts as the end of the one call, after OnDone.
  void ExpectHandled(const std::string& code) {
    stream_->OnDone();
    EXPECT_EQ(MetricOf(service_.metrics, kHandled + code + kLabels), 1) << code;
    EXPECT_EQ(service_.gate.open_count(), 0u);
  }
  grpc::StatusCode Finished() const { return transport_.finished.value_or(grpc::Status::OK).error_code(); }

  ServiceContext service_{TestServiceOptions()};
  FakeTransport transport_;
  std::shared_ptr<Protocol> stream_;
};

TEST_F(BidiStreamTest, ReadsTheNextMessageWhenTheProtocolAsksForIt) {
  Start();
  transport_.Deliver(*stream_, "one");
  EXPECT_EQ(transport_.reads, 2);
  stream_->reads_on = false;
  transport_.Deliver(*stream_, "two");
  EXPECT_EQ(transport_.reads, 2);
  stream_->ReadNext();
  EXPECT_EQ(transport_.reads, 3);
  transport_.DeliverEnd(*stream_);
  EXPECT_EQ(stream_->received, (std::vector<std::string>{"one", "two"}));
  EXPECT_TRUE(stream_->has_half_closed);
}

TEST_F(BidiStreamTest, WritesOneMessageAtATimeAndMakesNoneAhead) {
  Start();
  stream_->due = {"one", "two", "three"};
  stream_->WriteNext();
  stream_->WriteNext();
  EXPECT_EQ(stream_->made, 1);
  transport_.EndWrite(*stream_);
  EXPECT_EQ(stream_->made, 2);
  transport_.EndWrite(*stream_);
  transport_.EndWrite(*stream_);
  EXPECT_EQ(transport_.written, (std::vector<std::string>{"one", "two", "three"}));
  EXPECT_FALSE(transport_.finished.has_value());
}

TEST_F(BidiStreamTest, WritesWhatBecameDueWhileItFoundNothingToWrite) {
  Start();
  // Somebody asks while the protocol looks for a message in vain: what is due is found by the second look.
  Protocol& stream = *stream_;
  int asked = 0;
  stream.while_making = [&] {
    stream.while_making = [&] { stream.due.push_back("late"), ++asked; };
    stream.WriteNext();
  };
  stream.WriteNext();
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(transport_.written, std::vector<std::string>{"late"});
}

TEST_F(BidiStreamTest, AMessageThatCannotBeMadeEndsTheCall) {
  Start();
  stream_->while_making = [this] { stream_->End(absl::ResourceExhaustedError("no memory")); };
  stream_->WriteNext();
  EXPECT_TRUE(transport_.written.empty());
  EXPECT_EQ(Finished(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  ExpectHandled("RESOURCE_EXHAUSTED");
}

TEST_F(BidiStreamTest, EndsWithOkWhenAllIsWritten) {
  Start();
  stream_->due = {"last"};
  stream_->ends_when_written = true;
  stream_->WriteNext();
  EXPECT_FALSE(transport_.finished.has_value());
  transport_.EndWrite(*stream_);
  EXPECT_TRUE(transport_.finished.has_value());
  EXPECT_EQ(Finished(), grpc::StatusCode::OK);
  ExpectHandled("OK");
}

TEST_F(BidiStreamTest, TheStatusWaitsForTheWriteInFlightAndNotForTheRead) {
  Start();
  Send("one");
  stream_->due = {"never"};
  stream_->End(absl::InternalError("defect"));
  EXPECT_FALSE(transport_.finished.has_value());
  transport_.EndWrite(*stream_);
  EXPECT_EQ(Finished(), grpc::StatusCode::INTERNAL);
  EXPECT_EQ(transport_.written, std::vector<std::string>{"one"});
  transport_.DeliverEnd(*stream_);
  EXPECT_FALSE(stream_->has_half_closed);
  ExpectHandled("INTERNAL");
}

TEST_F(BidiStreamTest, StopsOnceBeforeTheStatusGoesOut) {
  Start();
  bool was_finished = true;
  stream_->on_stop = [&] {
    stream_->WriteNext();  // as another thread may
    was_finished = transport_.finished.has_value();
  };
  stream_->End(absl::InternalError("first"));
  stream_->End(absl::InternalError("second"));
  EXPECT_FALSE(was_finished);
  EXPECT_EQ(stream_->stops, 1);
  EXPECT_NE(transport_.finished->error_message().find("first"), std::string::npos);
}

// Somebody may end the stream while gRPC has not returned from a read that was started: its objects must live on.
TEST_F(BidiStreamTest, DoesNotFinishInTheMiddleOfACallIntoGrpc) {
  class EndingTransport final : public FakeTransport {
   public:
    void StartRead(grpc::ByteBuffer* message) override {
      FakeTransport::StartRead(message);
      if (stream != nullptr) stream->Abort(absl::UnavailableError("drain"));
      EXPECT_FALSE(finished.has_value());
    }
    BidiStream* stream = nullptr;
  } transport;
  const auto stream = std::make_shared<Protocol>(service_, ArrivalFrom("unix:"), transport);
  transport.stream = stream.get();
  stream->Start();
  ASSERT_TRUE(transport.finished.has_value());
  EXPECT_EQ(transport.finished->error_code(), grpc::StatusCode::UNAVAILABLE);
  stream->OnDone();
}

TEST_F(BidiStreamTest, AMessageThatArrivesAfterTheEndIsDropped) {
  Start();
  stream_->End(absl::InternalError("over"));
  transport_.Deliver(*stream_, "late");
  EXPECT_TRUE(stream_->received.empty());
  EXPECT_EQ(transport_.reads, 1);
}

TEST_F(BidiStreamTest, ACallerThatIsNotLetInGetsAStatusAndNoRead) {
  service_.access.SetTokens(OneToken("alice"));
  Start();
  EXPECT_EQ(transport_.reads, 0);
  EXPECT_EQ(Finished(), grpc::StatusCode::UNAUTHENTICATED);
  ExpectHandled("UNAUTHENTICATED");
}

TEST_F(BidiStreamTest, TheGateMayRefuseACall) {
  service_.gate.StartDraining();
  Start();
  EXPECT_EQ(transport_.reads, 0);
  EXPECT_EQ(Finished(), grpc::StatusCode::UNAVAILABLE);
  ExpectHandled("UNAVAILABLE");
}

TEST_F(BidiStreamTest, IsOpenAtTheGateUntilItIsDone) {
  Start();
  EXPECT_EQ(service_.gate.open_count(), 1u);
  stream_->End(absl::OkStatus());
  EXPECT_EQ(service_.gate.open_count(), 1u);
  ExpectHandled("OK");
}

TEST_F(BidiStreamTest, ACancelIsTheOutcome) {
  Start();
  stream_->OnCancel();
  EXPECT_EQ(Finished(), grpc::StatusCode::CANCELLED);
  ExpectHandled("CANCELLED");
}

// The half-close of a stream that broke off is no half-close, and its bad messages nobody's fault.
TEST_F(BidiStreamTest, WhatSeemedABadStreamWasBrokenOffIfACancelFollows) {
  Start();
  stream_->End(absl::InvalidArgumentError("points are missing"));
  stream_->OnCancel();
  ExpectHandled("CANCELLED");
}

TEST_F(BidiStreamTest, AnErrorThatIsNotTheCallersStaysWhenACancelFollows) {
  Start();
  stream_->End(absl::InternalError("defect"));
  stream_->OnCancel();
  ExpectHandled("INTERNAL");
}

TEST_F(BidiStreamTest, AWriteThatFailsMeansThatTheCallerIsGone) {
  Start();
  Send("one");
  transport_.EndWrite(*stream_, false);
  EXPECT_EQ(Finished(), grpc::StatusCode::CANCELLED);
}

TEST_F(BidiStreamTest, APeerThatSendsNothingIsToldSo) {
  Start();
  stream_->Tick(BidiStream::Clock::now());
  EXPECT_FALSE(transport_.finished.has_value());
  stream_->Tick(BidiStream::Clock::now() + seconds(11));
  EXPECT_EQ(Finished(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_NE(transport_.finished->error_message().find("time without a message"), std::string::npos);
  EXPECT_EQ(transport_.cancels, 0);
}

// A server that waits for memory or computes is not kept waiting.
TEST_F(BidiStreamTest, APeerThatIsNotReadDoesNotStall) {
  Start();
  stream_->reads_on = false;
  transport_.Deliver(*stream_, "one");
  stream_->Tick(BidiStream::Clock::now() + seconds(1000));
  EXPECT_FALSE(transport_.finished.has_value());
}

TEST_F(BidiStreamTest, APeerThatTakesNothingIsCutOff) {
  Start();
  stream_->reads_on = false;
  transport_.Deliver(*stream_, "all");
  Send("one");
  stream_->Tick(BidiStream::Clock::now() + seconds(11));
  EXPECT_EQ(transport_.cancels, 0) << "nothing that it must take is on its way";
  stream_->JudgeWrites();
  stream_->Tick(BidiStream::Clock::now() + seconds(11));
  EXPECT_EQ(transport_.cancels, 1);
  EXPECT_FALSE(transport_.finished.has_value());
  transport_.EndWrite(*stream_, false);
  EXPECT_EQ(Finished(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_NE(transport_.finished->error_message().find("room to send"), std::string::npos);
  ExpectHandled("DEADLINE_EXCEEDED");
}

// Else it would hold its memory for as long as it likes.
TEST_F(BidiStreamTest, APeerThatTakesNothingIsCutOffAlsoIfItsCallHasFailed) {
  Start();
  Send("one");
  stream_->End(absl::InvalidArgumentError("bad"));
  stream_->Tick(BidiStream::Clock::now() + seconds(9));
  EXPECT_EQ(transport_.cancels, 0);
  stream_->Tick(BidiStream::Clock::now() + seconds(11));
  EXPECT_EQ(transport_.cancels, 1);
  transport_.EndWrite(*stream_, false);
  EXPECT_TRUE(transport_.finished.has_value());
}

TEST_F(BidiStreamTest, ATickTellsWhetherAWriteIsInFlightAndLetsTheProtocolWrite) {
  Start();
  stream_->due = {"progress"};
  stream_->Tick(BidiStream::Clock::now());
  EXPECT_EQ(transport_.written, std::vector<std::string>{"progress"});
  stream_->Tick(BidiStream::Clock::now());
  EXPECT_EQ(stream_->ticks, (std::vector<bool>{false, true}));
}

}  // namespace
}  // namespace curvd
