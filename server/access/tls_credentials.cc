#include "server/access/tls_credentials.h"

#include <string>
#include <utility>

namespace curvd {
namespace {

// Credentials of gRPC's C interface, for a grpc::ServerBuilder.
class CoreCredentials final : public grpc::ServerCredentials {
 public:
  explicit CoreCredentials(grpc_server_credentials* credentials) : credentials_(credentials) {}
  ~CoreCredentials() override { grpc_server_credentials_release(credentials_); }
  CoreCredentials(const CoreCredentials&) = delete;
  CoreCredentials& operator=(const CoreCredentials&) = delete;

  // Tokens are checked in the calls, where a refusal can carry its reason.
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  grpc_server_credentials* const credentials_;
};

}  // namespace

TlsCredentials::TlsCredentials(TlsIdentity identity)
    : ask_clients_(!identity.client_authorities.empty()), identity_(std::move(identity)) {}

void TlsCredentials::Replace(TlsIdentity identity) {
  MutexLock lock(mutex_);
  identity_ = std::move(identity);
  fresh_ = true;
}

grpc_ssl_certificate_config_reload_status TlsCredentials::Fetch(void* self,
                                                                grpc_ssl_server_certificate_config** config) {
  return static_cast<TlsCredentials*>(self)->FetchFresh(config);
}

grpc_ssl_certificate_config_reload_status TlsCredentials::FetchFresh(grpc_ssl_server_certificate_config** config) {
  MutexLock lock(mutex_);
  if (!std::exchange(fresh_, false)) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  const grpc_ssl_pem_key_cert_pair pair = {identity_.private_key.c_str(), identity_.certificate_chain.c_str()};
  // gRPC aborts without authorities, also where it asks clients for nothing: then they are never used.
  const std::string& authorities = ask_clients_ ? identity_.client_authorities : identity_.certificate_chain;
  *config = grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

std::shared_ptr<grpc::ServerCredentials> TlsCredentials::ForServer() {
  grpc_ssl_server_credentials_options* options = grpc_ssl_server_credentials_create_options_using_config_fetcher(
      ask_clients_ ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                   : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
      Fetch, this);
  return std::make_shared<CoreCredentials>(grpc_ssl_server_credentials_create_with_options(options));
}

}  // namespace curvd
