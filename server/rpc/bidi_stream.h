// Serves a call with a stream of messages each way: reads, writes, ends and accounts, whatever the messages say.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "server/admission/stream_gate.h"
#include "server/rpc/rpc_account.h"
#include "server/rpc/stream_state.h"

namespace curvd {

// What a stream asks of gRPC; GrpcBidiReactor does it, and a test may stand in for it. Each but TryCancel is answered
// by an event of BidiStream, which may come before the function returns, on any thread.
class BidiTransport {
 public:
  virtual ~BidiTransport() = default;
  // Fills *message with the next message. Answered by OnReadDone.
  virtual void StartRead(grpc::ByteBuffer* message) = 0;
  // Sends *message. Answered by OnWriteDone.
  virtual void StartWrite(const grpc::ByteBuffer* message) = 0;
  // Sends the status; nothing may be asked after it. Answered by OnDone, when nothing else is in flight.
  virtual void Finish(const grpc::Status& status) = 0;
  // Ends the call at once, with everything in flight.
  virtual void TryCancel() = 0;
};

// gRPC reports events on threads of its own, some at the same time. Two chains of events, each with one link at a time,
// belong to the protocol that derives from this class:
// - reading: ReadNext, Receive, perhaps a wait, ReadNext ..., ReceiveEnd. A protocol that does not call ReadNext stops
// its
//   peer, by gRPC's flow control.
// - writing: MakeMessage is asked for the next message when the last one is gone, and when WriteNext was called.
// Whoever notices an end first (a bad message, a cancel, a drain) gives the stream its outcome by End, and the status
// goes out as soon as StreamState allows. No call into gRPC, and none of the protocol's functions, is made with the
// mutex held, since gRPC may report the next event before it returns.
//
// Messages are bytes: gRPC would report one that it cannot parse as the end of the stream.
//
// The object lives until gRPC is done with it (GrpcBidiReactor holds it) and nobody else holds it. Thread-safe.
class BidiStream : public OpenStream, public std::enable_shared_from_this<BidiStream> {
 public:
  using Clock = std::chrono::steady_clock;

  // `service` must outlive the stream, and `transport` live until OnDone.
  BidiStream(ServiceContext& service, RpcMethod method, const RpcArrival& arrival, BidiTransport& transport)
      : service_(service), account_(service, method, arrival), transport_(transport) {}

  // Lets the call in and reads its first message, or ends it. REQUIRES: called once, before any event.
  void Start();

  // Events of the transport. `ok` is false if there was no further message, or if the call is broken.
  void OnReadDone(bool ok);
  void OnWriteDone(bool ok);
  void OnCancel();
  // The last event.
  void OnDone();

  // Of OpenStream.
  void Tick(Clock::time_point now) final;
  void Abort(absl::Status status) final { End(std::move(status)); }

 protected:
  enum class Made { kMessage, kNothing, kLast };

  // The reading chain. Takes a message; leaves nothing in it that need not be kept until the next.
  virtual void Receive(grpc::ByteBuffer& message) = 0;
  // The reading chain ends: the peer has half-closed, or the stream was broken off, which looks the same. In the latter
  // case a cancel follows.
  virtual void ReceiveEnd() = 0;
  // The writing chain. Makes the next message, if one is due; kLast if all were written and the call ends with OK.
  // Where a message cannot be made, it calls End with the reason, and returns kNothing.
  virtual Made MakeMessage(grpc::ByteBuffer& message) = 0;
  // Whether other calls wait for what this one holds. A peer must then keep up the pace of PeerPace.
  virtual bool IsMissed() { return false; }
  // Five times a second, with the time; `is_writing`: a message is on its way, or being made.
  virtual void OnTick(Clock::time_point now, bool is_writing) = 0;
  // The stream has its outcome: stops what goes on for it. Called once; no status goes out before it returns.
  virtual void Stop() = 0;
  // The call is over. Completes account().record(). Called once, after all else but callbacks of the protocol's own.
  virtual void CompleteRecord(CallRecord& record) = 0;

  // Reads the next message. No effect once there is an outcome. REQUIRES: called by the reading chain.
  void ReadNext();
  // The message that was received last brought the call on by so many bytes; none, if it brought nothing. Peers who
  // bring nothing for too long are cut off. REQUIRES: called by the reading chain, once for each message.
  void CountProgress(uint64_t bytes);
  // From now on the peer must take what is written, or is cut off.
  void JudgeWrites();
  // There may be something new to write.
  void WriteNext();
  // Gives the stream its outcome, unless it has one.
  void End(absl::Status outcome);

  ServiceContext& service() { return service_; }
  RpcAccount& account() { return account_; }

 private:
  void EndStalled(StreamState::Stall stall);
  void Release();
  void Finish();
  void Send();

  ServiceContext& service_;
  RpcAccount account_;
  BidiTransport& transport_;
  grpc::ByteBuffer incoming_;  // of the reading chain
  grpc::ByteBuffer outgoing_;  // of the writing chain

  Mutex mutex_;
  StreamState state_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
