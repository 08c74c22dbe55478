// Checks certificates and keys as they are read, of which gRPC tells only when a call fails, and not which file is
// wrong.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace curv {

// INVALID_ARGUMENT, naming flag, file and what was expected, unless `pem`, what `file` holds, begins with a certificate
// as PEM.
absl::Status CheckCertificate(const std::string& flag, const std::string& file, const std::string& pem);

// The same unless it holds a private key as PEM, without a password, and that of the first certificate in
// `certificate`. REQUIRES: CheckCertificate(certificate) is OK.
absl::Status CheckPrivateKey(const std::string& flag, const std::string& file, const std::string& pem,
                             const std::string& certificate);

}  // namespace curv
