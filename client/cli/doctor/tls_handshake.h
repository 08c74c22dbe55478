// Shakes hands as gRPC would, and tells what it does not: whose certificate the server has, until when, of whom.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/cli/doctor/socket.h"
#include "client/connect_options.h"

namespace curv {

struct TlsHandshake {
  std::string version;        // "TLSv1.3"
  bool speaks_http2 = false;  // agreed upon by ALPN
  std::string subject;        // of the server's certificate, "CN = curvd.example"
  std::string issuer;
  std::vector<std::string> names;  // DNS names and addresses that the certificate is for
  absl::Time not_before;
  absl::Time not_after;
  bool fits_name = false;
  std::string distrust;  // why the chain of certificates is not trusted, dates aside; empty where it is
  bool asks_for_certificate = false;
  std::string complaint;  // what the server ended the connection with after the handshake; empty where it did not
};

// Shakes hands on a new connection, and says the first words of HTTP/2 over it. A certificate that is not good does not
// end it. `name` is what the certificate must be for; authorities and certificate are those of `options`. UNAVAILABLE
// if no connection comes about; FAILED_PRECONDITION, with what OpenSSL says, if the server speaks no TLS or refuses the
// handshake; INVALID_ARGUMENT if `options` has PEM that cannot be read.
absl::StatusOr<TlsHandshake> ShakeHands(const Address& address, const std::string& name, const ConnectOptions& options,
                                        absl::Duration timeout);

}  // namespace curv
