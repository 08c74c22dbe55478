#include "server/observe/stranger_log.h"

namespace curvd {
namespace {

// What a reason means, for whoever reads the log.
const char* MeaningOf(StrangerReason reason) {
  switch (reason) {
    case StrangerReason::kConnectionLimit:
      return "--max-connections connections are open";
    case StrangerReason::kPeerConnectionLimit:
      return "this address has --max-connections-per-peer connections open";
    case StrangerReason::kNoDescriptor:
      return "the process has no descriptor left for a connection";
    case StrangerReason::kHandshakeTimeout:
      return "the connection ended when --handshake-timeout was over, without a call";
    case StrangerReason::kNothingSent:
      return "the connection ended before it had sent anything";
    case StrangerReason::kNoCall:
      return "the connection ended without a call: its handshake failed, it spoke no HTTP/2, or it only connected";
    case StrangerReason::kNotLetIn:
      return "the connection ended, and none of its calls had been let in";
    case StrangerReason::kUnaccountedBytes:
      return "the server ended the connection, as it had sent more than its calls account for";
    case StrangerReason::kTooMuchMetadata:
      return "the server ended the connection, as one of its calls had more than twice --max-header-bytes of metadata";
    case StrangerReason::kMemoryShort:
      return "the server ended the connection, or did not take it, as the process had too much memory";
  }
  return "";
}

}  // namespace

void StrangerLog::Note(const Stranger& stranger) {
  metrics_.CountStranger(stranger.reason);
  uint64_t left_out = 0;
  if (stranger.reason == StrangerReason::kNothingSent) return;
  if (!limit_.MayWrite(LogRateLimit::Clock::now(), left_out)) return;
  JsonLine line;
  line.Add("reason", StrangerReasonName(stranger.reason));
  if (!stranger.peer.empty()) line.Add("peer", stranger.peer);
  if (stranger.seconds.has_value()) line.Add("seconds", *stranger.seconds);
  if (stranger.received_bytes.has_value()) line.Add("received_bytes", *stranger.received_bytes);
  line.Add("message", MeaningOf(stranger.reason));
  if (left_out > 0) line.Add("lines_left_out", left_out);
  log_.Log(ServerLog::Level::kWarning, "stranger", line);
}

}  // namespace curvd
