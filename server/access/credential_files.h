// Follows the files that say who the server is and who may call it while it runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/access/access_control.h"
#include "server/access/tls_credentials.h"
#include "server/access/watched_file.h"
#include "server/observe/security_metrics.h"
#include "server/observe/server_log.h"
#include "server/server_options.h"

namespace curvd {

// Loads certificates, tokens and names at the start, and again when a file changes. A file that has become wrong, and a
// certificate that has ended in place of one that has not, change nothing: what was read last stays in force, and log
// and metrics tell. Not thread-safe.
class CredentialFiles {
 public:
  // `access`, `metrics` and `log` must outlive this.
  CredentialFiles(const ServerOptions& options, AccessControl& access, SecurityMetrics& metrics, ServerLog& log);

  // INVALID_ARGUMENT or UNAVAILABLE, naming flag and file, if one cannot be used.
  absl::Status LoadAll();
  // Loads what has changed since. Returns whether who may call has changed.
  bool Refresh();

  // Null without a certificate. Valid after LoadAll, as long as this.
  TlsCredentials* tls() { return tls_.get(); }

 private:
  enum class Kind { kCertificate, kTokens, kClientNames };
  // Files that only make sense together.
  struct Group {
    Kind kind;
    std::vector<WatchedFile> files;
    bool failed = false;  // when it was loaded last
  };

  absl::Status Load(const Group& group);
  absl::Status LoadCertificate(const Group& group);

  AccessControl& access_;
  SecurityMetrics& metrics_;
  ServerLog& log_;
  std::vector<Group> groups_;
  std::unique_ptr<TlsCredentials> tls_;
  absl::Time expires_ = absl::InfinitePast();  // the certificate in force
};

}  // namespace curvd
