#include "server/access/tls_identity.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <memory>
#include <utility>

#include "proto/open_ssl.h"

namespace curvd {
namespace {

template <auto Free>
struct Freed {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;

Bio Reader(const std::string& text) { return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))); }

// A key with a passphrase must fail; by default OpenSSL would ask the terminal for it.
int NoPassphrase(char*, int, int, void*) { return 0; }

Certificate FirstCertificate(const std::string& pem) {
  return Certificate(PEM_read_bio_X509(Reader(pem).get(), nullptr, NoPassphrase, nullptr));
}

absl::Time ExpiryOf(const X509& certificate) {
  std::tm time = {};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(&certificate), &time) != 1) return absl::InfinitePast();
  return absl::FromTM(time, absl::UTCTimeZone());
}

}  // namespace

absl::StatusOr<TlsIdentity> MakeTlsIdentity(std::string certificate_chain, std::string private_key,
                                            std::string client_authorities) {
  KeepOpenSslAtExit();
  const Certificate certificate = FirstCertificate(certificate_chain);
  const Key key(PEM_read_bio_PrivateKey(Reader(private_key).get(), nullptr, NoPassphrase, nullptr));
  const bool authorities_fit = client_authorities.empty() || FirstCertificate(client_authorities) != nullptr;
  const bool pair_fits =
      certificate != nullptr && key != nullptr && X509_check_private_key(certificate.get(), key.get()) == 1;
  ERR_clear_error();
  if (certificate == nullptr) return absl::InvalidArgumentError("the certificate is no PEM certificate");
  if (key == nullptr) return absl::InvalidArgumentError("the key is no PEM private key without a passphrase");
  if (!pair_fits) return absl::InvalidArgumentError("the key is not that of the certificate");
  if (!authorities_fit) return absl::InvalidArgumentError("the client authorities hold no PEM certificate");
  const absl::Time expires = ExpiryOf(*certificate);
  return TlsIdentity{std::move(certificate_chain), std::move(private_key), std::move(client_authorities), expires};
}

}  // namespace curvd
