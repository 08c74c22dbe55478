#include "server/observe/stranger_log.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace curvd {
namespace {

constexpr int kLinesPerSecond = 20;

struct Symptom {
  const char* text;
  StrangerReason reason;
  const char* meaning;
};

// What OpenSSL and gRPC say when a handshake fails, and what it means. The first that matches counts.
constexpr Symptom kSymptoms[] = {
    {"peer did not return a certificate", StrangerReason::kNoCertificate, "the client showed no certificate"},
    {"certificate verify failed", StrangerReason::kBadCertificate,
     "the client's certificate has expired or is of an authority that is not trusted"},
    {"wrong version number", StrangerReason::kPlainText, "the client spoke plain text to the TLS port"},
    {"http request", StrangerReason::kPlainText, "the client spoke plain text to the TLS port"},
    {"Handshake timed out", StrangerReason::kHandshakeTimeout, "the client did not finish its handshake in time"},
    {"alert", StrangerReason::kHandshakeFailed,
     "the client broke the handshake off, as when it does not trust curvd's certificate"},
    {"", StrangerReason::kHandshakeFailed, "the handshake failed"},
};

const Symptom& Diagnose(const std::string& message) {
  for (const Symptom& symptom : kSymptoms) {
    if (absl::StrContains(message, symptom.text)) return symptom;
  }
  return kSymptoms[std::size(kSymptoms) - 1];
}

// The address that gRPC's line tells, as it does where reading or writing failed; "" if it tells none.
std::string AddressIn(const std::string& message) {
  constexpr char kBefore[] = "target_address:\"";
  const size_t found = message.find(kBefore);
  if (found == std::string::npos) return "";
  const size_t begin = found + sizeof(kBefore) - 1;
  return message.substr(begin, message.find('"', begin) - begin);
}

}  // namespace

bool StrangerLog::MayLog(uint64_t& left_out) {
  const Clock::time_point now = Clock::now();
  MutexLock lock(mutex_);
  if (now - second_ >= std::chrono::seconds(1)) {
    second_ = now;
    lines_ = 0;
  }
  if (lines_ == kLinesPerSecond) {
    ++left_out_;
    return false;
  }
  ++lines_;
  left_out = std::exchange(left_out_, 0);
  return true;
}

void StrangerLog::FindPeersWith(std::function<std::string()> peer_being_closed) {
  MutexLock lock(peer_mutex_);
  peer_being_closed_ = std::move(peer_being_closed);
}

std::string StrangerLog::PeerOfFailedHandshake(const std::string& message) {
  if (std::string address = AddressIn(message); !address.empty()) return address;
  // gRPC shuts the connection down, then writes the line, then closes the connection.
  MutexLock lock(peer_mutex_);
  return peer_being_closed_ ? peer_being_closed_() : "";
}

void StrangerLog::Note(StrangerReason reason, const std::string& peer, const std::string& message) {
  NoteAndFind(
      reason, [&peer] { return peer; }, message);
}

void StrangerLog::NoteAndFind(StrangerReason reason, const std::function<std::string()>& find_peer,
                              const std::string& message) {
  metrics_.CountStranger(reason);
  uint64_t left_out = 0;
  if (!MayLog(left_out)) return;
  JsonLine line;
  line.Add("reason", StrangerReasonName(reason));
  if (const std::string peer = find_peer(); !peer.empty()) line.Add("peer", peer);
  line.Add("message", message);
  if (left_out > 0) line.Add("lines_left_out", left_out);
  log_.Log(ServerLog::Level::kWarning, "stranger", line);
}

void StrangerLog::NoteRefused(StrangerReason reason, const std::string& peer) {
  Note(reason, peer,
       reason == StrangerReason::kNoDescriptor          ? "the process has no descriptor left for a connection"
       : reason == StrangerReason::kPeerConnectionLimit ? "this address has --max-connections-per-peer connections open"
                                                        : "--max-connections connections are open");
}

void StrangerLog::NoteGrpcLine(const std::string& file, const std::string& message, bool is_error) {
  if (absl::StartsWith(message, "Handshaking failed: ")) {
    const Symptom& symptom = Diagnose(message);
    NoteAndFind(
        symptom.reason, [this, &message] { return PeerOfFailedHandshake(message); }, symptom.meaning);
  } else if (absl::StartsWith(message, "received initial metadata size exceeds limit")) {
    Note(StrangerReason::kHeaderTooLarge, "", "a call's metadata is over --max-header-bytes");
  } else if (is_error && !absl::StartsWith(message, "Handshake failed with fatal error")) {  // told twice by gRPC
    uint64_t left_out = 0;
    if (MayLog(left_out)) {
      log_.Log(ServerLog::Level::kError, "grpc", JsonLine().Add("source", file).Add("message", message));
    }
  }
}

}  // namespace curvd
