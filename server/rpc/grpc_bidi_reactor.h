// Joins a BidiStream to gRPC.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <utility>

#include "server/rpc/bidi_stream.h"

namespace curvd {

// Passes gRPC's events on to the stream, and what the stream asks on to gRPC. Holds the stream, and owns itself, until
// OnDone. Thread-safe.
class GrpcBidiReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>, public BidiTransport {
 public:
  // The reactor of a call that has just arrived, with a stream of class Stream, whose constructor takes the service,
  // the arrival and the transport.
  template <typename Stream>
  static GrpcBidiReactor* Serve(ServiceContext& service, grpc::CallbackServerContext& call) {
    auto* reactor = new GrpcBidiReactor(call);
    reactor->stream_ = std::make_shared<Stream>(service, ArrivalOf(call), *reactor);
    reactor->stream_->Start();
    return reactor;
  }

  void OnReadDone(bool ok) override { stream_->OnReadDone(ok); }
  void OnWriteDone(bool ok) override { stream_->OnWriteDone(ok); }
  void OnCancel() override { stream_->OnCancel(); }
  void OnDone() override {
    stream_->OnDone();
    delete this;
  }

  void StartRead(grpc::ByteBuffer* message) override { Base::StartRead(message); }
  void StartWrite(const grpc::ByteBuffer* message) override { Base::StartWrite(message); }
  void Finish(const grpc::Status& status) override { Base::Finish(status); }
  void TryCancel() override { call_.TryCancel(); }

 private:
  using Base = grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>;

  explicit GrpcBidiReactor(grpc::CallbackServerContext& call) : call_(call) {}

  grpc::CallbackServerContext& call_;
  std::shared_ptr<BidiStream> stream_;
};

}  // namespace curvd
