#include "client/cli/pem/pem_checks.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>

#include "absl/strings/str_cat.h"
#include "proto/open_ssl.h"

namespace curv {
namespace {

using ReadBio = std::unique_ptr<BIO, decltype(&BIO_free_all)>;
using ReadCertificate = std::unique_ptr<X509, decltype(&X509_free)>;
using ReadKey = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

// OpenSSL would ask the terminal for a password unless it is given one.
constexpr char kNoPassword[] = "";

ReadBio BioOf(const std::string& text) {
  curvd::KeepOpenSslAtExit();
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), BIO_free_all};
}

ReadCertificate CertificateIn(const std::string& pem) {
  const ReadBio bio = BioOf(pem);
  ReadCertificate certificate(PEM_read_bio_X509_AUX(bio.get(), nullptr, nullptr, const_cast<char*>(kNoPassword)),
                              X509_free);
  ERR_clear_error();
  return certificate;
}

ReadKey KeyIn(const std::string& pem) {
  const ReadBio bio = BioOf(pem);
  ReadKey key(PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, const_cast<char*>(kNoPassword)), EVP_PKEY_free);
  ERR_clear_error();
  return key;
}

}  // namespace

absl::Status CheckCertificate(const std::string& flag, const std::string& file, const std::string& pem) {
  if (CertificateIn(pem) != nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      flag, ": ", file, ": no certificate can be read from it; expected PEM, as after -----BEGIN CERTIFICATE-----"));
}

absl::Status CheckPrivateKey(const std::string& flag, const std::string& file, const std::string& pem,
                             const std::string& certificate) {
  const ReadKey key = KeyIn(pem);
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(flag, ": ", file,
                     ": no private key can be read from it; expected PEM without a password, as after -----BEGIN "
                     "PRIVATE KEY-----"));
  }
  const bool fits = X509_check_private_key(CertificateIn(certificate).get(), key.get()) == 1;
  ERR_clear_error();
  if (fits) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(flag, ": ", file, ": it is the private key of another certificate"));
}

}  // namespace curv
