// Who may call: bearer tokens and names of client certificates, from files that may change while the server runs.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "proto/access_list.h"
#include "server/access/caller.h"

namespace curvd {

// What a call shows of who makes it.
struct PresentedCredentials {
  std::optional<std::string> authorization;    // the metadata of that name
  std::vector<std::string> certificate_names;  // of a certificate that was verified: common name, alternative names
  std::string peer;                            // as gRPC writes it: "ipv4:10.0.0.7:1234"
};

// Without lists, anybody may call; with both, a call needs a token and a certificate with a name. Thread-safe.
class AccessControl {
 public:
  // Null: no token, no name is asked for.
  using Entries = std::shared_ptr<const std::vector<AccessEntry>>;

  void SetTokens(Entries tokens);
  void SetCertificateNames(Entries names);

  // Who the caller is. Errors, which never repeat what the caller sent as a token:
  // - UNAUTHENTICATED, TOKEN_MISSING: no "authorization: Bearer TOKEN".
  // - UNAUTHENTICATED, TOKEN_INVALID: a token that is not in the list, or no more.
  // - PERMISSION_DENIED, CLIENT_NOT_ALLOWED: no name of the certificate is in the list.
  absl::StatusOr<Caller> Identify(const PresentedCredentials& presented) const;

  // Whether a caller that was let in earlier would still be: OK, or the error that Identify would give now.
  absl::Status Recheck(const Caller& caller) const;

 private:
  mutable Mutex mutex_;
  Entries tokens_ ABSL_GUARDED_BY(mutex_);
  Entries names_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
