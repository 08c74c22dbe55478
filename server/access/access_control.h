// Decides who may call, by bearer tokens and names of client certificates, which may change while the server runs.
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
#include "server/access/access_table.h"
#include "server/access/caller.h"

namespace curvd {

// Holds what a call shows of who makes it.
struct PresentedCredentials {
  std::optional<std::string> authorization;    // the metadata of that name
  std::vector<std::string> certificate_names;  // of a certificate that was verified: common name, alternative names
  std::string peer;                            // as gRPC writes it: "ipv4:10.0.0.7:1234"
};

// Without lists, anybody may call; with both, a call needs a token and a certificate with a name. Thread-safe.
class AccessControl {
 public:
  // From now on a call must carry one of these tokens, or a certificate with one of these names. Calls are let in and
  // checked meanwhile, by what was set before.
  void SetTokens(std::vector<AccessEntry> tokens);
  void SetCertificateNames(std::vector<AccessEntry> names);

  // Who the caller is. Errors, which never repeat what the caller sent as a token:
  // - UNAUTHENTICATED, TOKEN_MISSING: no "authorization: Bearer TOKEN".
  // - UNAUTHENTICATED, TOKEN_INVALID: a token that is not in the list, or no more.
  // - PERMISSION_DENIED, CLIENT_NOT_ALLOWED: no name of the certificate is in the list.
  absl::StatusOr<Caller> Identify(const PresentedCredentials& presented) const;

  // Whether a caller that was let in earlier would still be: OK, or the error that Identify would give now.
  absl::Status Recheck(const Caller& caller) const;

 private:
  using Table = std::shared_ptr<const AccessTable>;  // null: none is asked for
  struct Tables {
    Table tokens, names;
  };
  Tables CurrentTables() const;

  mutable Mutex mutex_;
  Table tokens_ ABSL_GUARDED_BY(mutex_);
  Table names_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace curvd
