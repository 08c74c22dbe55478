// Checks that a certificate, its key, and the authorities of client certificates fit together.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace curvd {

struct TlsIdentity {
  std::string certificate_chain;  // the server's own first
  std::string private_key;
  std::string client_authorities;  // empty: clients show no certificate
  absl::Time expires;              // the server's own certificate
};

// Checks the texts as a handshake would need them. INVALID_ARGUMENT, saying which text is wrong and how but quoting
// nothing of the key, if one cannot be read, the key is not the certificate's, or there is no authority in
// `client_authorities` (unless that is empty).
absl::StatusOr<TlsIdentity> MakeTlsIdentity(std::string certificate_chain, std::string private_key,
                                            std::string client_authorities);

}  // namespace curvd
