#include "client/cli/doctor/tls_handshake.h"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/doctor/greeting.h"
#include "proto/open_ssl.h"

namespace curv {
namespace {

template <auto kFree>
struct Freed {
  template <typename T>
  void operator()(T* object) const {
    kFree(object);
  }
};
template <typename T, auto kFree>
using Owned = std::unique_ptr<T, Freed<kFree>>;
using OwnedBio = Owned<BIO, BIO_free_all>;
using OwnedContext = Owned<SSL_CTX, SSL_CTX_free>;
using OwnedCertificate = Owned<X509, X509_free>;
using OwnedKey = Owned<EVP_PKEY, EVP_PKEY_free>;

// The first error of OpenSSL that waits to be told.
std::string OpenSslError() {
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return reason == nullptr ? "the connection was closed" : reason;
}

OwnedBio Read(const std::string& text) { return OwnedBio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))); }

absl::Status TrustAuthorities(SSL_CTX* context, const std::string& pem) {
  if (pem.empty()) {
    SSL_CTX_set_default_verify_paths(context);
    return absl::OkStatus();
  }
  const OwnedBio bio = Read(pem);
  int count = 0;
  while (const OwnedCertificate certificate{PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr)}) {
    X509_STORE_add_cert(SSL_CTX_get_cert_store(context), certificate.get());
    ++count;
  }
  ERR_clear_error();  // the end of the file is one
  return count > 0 ? absl::OkStatus()
                   : absl::InvalidArgumentError("no certificate can be read from the authorities (--ca)");
}

absl::Status ShowCertificate(SSL_CTX* context, const ConnectOptions& options) {
  if (options.certificate.empty()) return absl::OkStatus();
  const OwnedBio chain = Read(options.certificate);
  const OwnedCertificate own{PEM_read_bio_X509(chain.get(), nullptr, nullptr, nullptr)};
  if (own == nullptr || SSL_CTX_use_certificate(context, own.get()) != 1) {
    return absl::InvalidArgumentError(absl::StrCat("the client certificate (--cert) cannot be read: ", OpenSslError()));
  }
  while (X509* next = PEM_read_bio_X509(chain.get(), nullptr, nullptr, nullptr)) {
    SSL_CTX_add0_chain_cert(context, next);
  }
  ERR_clear_error();
  const OwnedBio text = Read(options.private_key);
  const OwnedKey key{PEM_read_bio_PrivateKey(text.get(), nullptr, nullptr, nullptr)};
  if (key == nullptr || SSL_CTX_use_PrivateKey(context, key.get()) != 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("the key (--key) is not that of the certificate (--cert): ", OpenSslError()));
  }
  return absl::OkStatus();
}

absl::StatusOr<OwnedContext> MakeContext(const ConnectOptions& options) {
  curvd::KeepOpenSslAtExit();
  OwnedContext context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  // What is wrong with a certificate is to be told, all of it.
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_NONE, nullptr);
  constexpr unsigned char kProtocols[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kProtocols, sizeof(kProtocols));
  for (const absl::Status& status :
       {TrustAuthorities(context.get(), options.authorities), ShowCertificate(context.get(), options)}) {
    if (!status.ok()) return status;
  }
  return context;
}

std::string TextOf(const X509_NAME* name) {
  const OwnedBio bio(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(bio.get(), name, 0, XN_FLAG_ONELINE);
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &text);
  return std::string(text, static_cast<size_t>(size));
}

absl::Time TimeOf(const ASN1_TIME* time) {
  std::tm parts = {};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return absl::InfinitePast();
  return absl::FromTM(parts, absl::UTCTimeZone());
}

std::vector<std::string> NamesOf(X509* certificate) {
  std::vector<std::string> names;
  using OwnedNames = Owned<GENERAL_NAMES, GENERAL_NAMES_free>;
  const OwnedNames all(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; all != nullptr && i < sk_GENERAL_NAME_num(all.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(all.get(), i);
    if (name->type == GEN_DNS) {
      names.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(name->d.dNSName)),
                         static_cast<size_t>(ASN1_STRING_length(name->d.dNSName)));
    } else if (name->type == GEN_IPADD) {
      char text[INET6_ADDRSTRLEN] = "";
      const int family = ASN1_STRING_length(name->d.iPAddress) == 4 ? AF_INET : AF_INET6;
      if (ASN1_STRING_length(name->d.iPAddress) != (family == AF_INET ? 4 : 16)) continue;
      inet_ntop(family, ASN1_STRING_get0_data(name->d.iPAddress), text, sizeof(text));
      names.emplace_back(text);
    }
  }
  return names;
}

// Dates are judged apart, by the clock that the caller names.
std::string DistrustOf(long verified) {
  const bool is_date = verified == X509_V_ERR_CERT_HAS_EXPIRED || verified == X509_V_ERR_CERT_NOT_YET_VALID;
  return verified == X509_V_OK || is_date ? "" : X509_verify_cert_error_string(verified);
}

void Describe(SSL* ssl, const std::string& name, TlsHandshake& handshake) {
  handshake.version = SSL_get_version(ssl);
  const unsigned char* protocol = nullptr;
  unsigned length = 0;
  SSL_get0_alpn_selected(ssl, &protocol, &length);
  handshake.speaks_http2 = std::string_view(reinterpret_cast<const char*>(protocol), length) == "h2";
  handshake.distrust = DistrustOf(SSL_get_verify_result(ssl));
  X509* certificate = SSL_get0_peer_certificate(ssl);
  if (certificate == nullptr) return;
  handshake.subject = TextOf(X509_get_subject_name(certificate));
  handshake.issuer = TextOf(X509_get_issuer_name(certificate));
  handshake.names = NamesOf(certificate);
  handshake.not_before = TimeOf(X509_get0_notBefore(certificate));
  handshake.not_after = TimeOf(X509_get0_notAfter(certificate));
  handshake.fits_name = X509_check_host(certificate, name.data(), name.size(), 0, nullptr) == 1 ||
                        X509_check_ip_asc(certificate, name.c_str(), 0) == 1;
}

// A server of TLS 1.3 refuses a client's certificate only once it has shaken hands.
std::string ComplaintAfterwards(SSL* ssl) {
  char first;
  const bool is_fine =
      SSL_write(ssl, kHttp2Preface.data(), static_cast<int>(kHttp2Preface.size())) > 0 && SSL_read(ssl, &first, 1) == 1;
  return is_fine ? "" : OpenSslError();
}

}  // namespace

absl::StatusOr<TlsHandshake> ShakeHands(const Address& address, const std::string& name, const ConnectOptions& options,
                                        absl::Duration timeout) {
  absl::StatusOr<OwnedContext> context = MakeContext(options);
  if (!context.ok()) return context.status();
  const absl::StatusOr<Socket> socket = Socket::Connect(address, timeout);
  if (!socket.ok()) return absl::UnavailableError(socket.status().message());
  const Owned<SSL, SSL_free> ssl(SSL_new(context->get()));
  SSL_set_fd(ssl.get(), socket->descriptor());
  // Names of hosts alone may be sent (RFC 6066, section 3).
  in6_addr ignored;
  if (inet_pton(AF_INET, name.c_str(), &ignored) != 1 && inet_pton(AF_INET6, name.c_str(), &ignored) != 1) {
    SSL_set_tlsext_host_name(ssl.get(), name.c_str());
  }
  TlsHandshake handshake;
  SSL_set_cert_cb(
      ssl.get(),
      [](SSL*, void* was_asked) {
        *static_cast<bool*>(was_asked) = true;
        return 1;
      },
      &handshake.asks_for_certificate);
  if (SSL_connect(ssl.get()) != 1) return absl::FailedPreconditionError(OpenSslError());
  Describe(ssl.get(), name, handshake);
  handshake.complaint = ComplaintAfterwards(ssl.get());
  return handshake;
}

}  // namespace curv
