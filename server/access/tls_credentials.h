// Gives a gRPC server TLS, with a certificate that may change while it runs.
#pragma once

#include <grpc/grpc_security.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/access/tls_identity.h"

namespace curvd {

// What handshakes use. gRPC's C++ interface knows a certificate that changes only as an experiment that neither checks
// whether the key fits nor tells of failures; its C interface asks for the certificate before each handshake. TLS 1.2
// and later. Thread-safe.
class TlsCredentials {
 public:
  // Clients must show a certificate of one of identity.client_authorities if there are any.
  explicit TlsCredentials(TlsIdentity identity);

  // Handshakes that begin from now on use `identity`. Whether clients need a certificate stays as it was.
  void Replace(TlsIdentity identity);

  // Credentials for one listening port. REQUIRES: called once, and this outlives the server that uses them.
  std::shared_ptr<grpc::ServerCredentials> ForServer();

 private:
  static grpc_ssl_certificate_config_reload_status Fetch(void* self, grpc_ssl_server_certificate_config** config);
  grpc_ssl_certificate_config_reload_status FetchFresh(grpc_ssl_server_certificate_config** config);

  const bool ask_clients_;
  Mutex mutex_;
  TlsIdentity identity_ ABSL_GUARDED_BY(mutex_);
  bool fresh_ ABSL_GUARDED_BY(mutex_) = true;  // gRPC has not seen identity_
};

}  // namespace curvd
