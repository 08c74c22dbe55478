// Finds out what is spoken on a port.
#pragma once

#include <string>
#include <string_view>

#include "absl/time/time.h"
#include "client/cli/doctor/socket.h"

namespace curv {

enum class Greeting {
  kHttp2,    // as gRPC speaks it
  kHttp1,    // HTTP, but no frames of HTTP/2
  kTls,      // a complaint in TLS
  kOther,    // bytes of another protocol
  kClosed,   // the end of the connection without a byte
  kSilence,  // nothing in time
};

// What a client of HTTP/2 says first (RFC 9113, section 3.4), with settings that change nothing.
extern const std::string_view kHttp2Preface;

// Which of them the first bytes of an answer to kHttp2Preface are; for no bytes, kClosed.
Greeting GreetingOf(std::string_view answer);

// Says kHttp2Preface in plain text over a connection of its own, and tells what comes back. Errors as Socket::Connect.
absl::StatusOr<Greeting> GreetInPlainText(const Address& address, absl::Duration timeout);

}  // namespace curv
