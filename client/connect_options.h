// How a client reaches servers that ask who it is.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace curv {

struct ConnectOptions {
  // Encrypts, and checks that the server's certificate is good for the name that was asked for. DEFAULT: plain text.
  bool tls = false;
  // Authorities that the server's certificate may be of, PEM. DEFAULT: empty, those of the system.
  std::string authorities;
  // The certificate chain that the client shows, and its private key, PEM; both or none. DEFAULT: none.
  std::string certificate;
  std::string private_key;
  // The name to find in the server's certificate, where that is not the host in the address. DEFAULT: empty.
  std::string server_name;

  // Looks names up once, at Connect, and starts with any of their addresses: for a program that makes one call, which
  // the first address would get nearly always. Otherwise gRPC looks them up, takes turns, and sees when addresses
  // change. DEFAULT: false.
  bool resolve_once = false;

  // Sent with each call as "authorization: Bearer TOKEN". DEFAULT: none.
  std::string token;
  // Whether the token may go to other machines without TLS. DEFAULT: false.
  bool send_token_in_plain_text = false;
};

// INVALID_ARGUMENT if options that only make sense together are not given together, if certificate or key is not PEM,
// or if the token is empty, too long, or has bytes that no header can carry. Messages never quote key or token.
absl::Status CheckConnectOptions(const ConnectOptions& options);

// INVALID_ARGUMENT, which never quotes the token, if it is too long, or has bytes that no header can carry.
absl::Status CheckToken(const std::string& token);

// Whether `target` ("HOST:PORT", "unix:PATH") is on this machine for sure.
bool IsLocalTarget(const std::string& target);

// `status`, with what probably is the matter where a connection failed for reasons of TLS or because of the lack of it:
// gRPC tells of those in words of OpenSSL, or not at all.
absl::Status ExplainConnectError(const absl::Status& status, bool tls, bool has_certificate);

}  // namespace curv
