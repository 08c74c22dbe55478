#include "server/access/credential_files.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace curvd {
namespace {

// A certificate that ends sooner is worth a warning whenever it is loaded.
constexpr absl::Duration kExpiryWarning = absl::Hours(7 * 24);

absl::Status Explain(const absl::Status& status, const std::string& what) {
  return absl::Status(status.code(), absl::StrCat(what, ": ", status.message()));
}

}  // namespace

CredentialFiles::CredentialFiles(const ServerOptions& options, AccessControl& access, SecurityMetrics& metrics,
                                 ServerLog& log)
    : access_(access), metrics_(metrics), log_(log) {
  if (!options.tls_cert.empty()) {
    Group& group = groups_.emplace_back(Group{Kind::kCertificate, {}});
    group.files.emplace_back(options.tls_cert);
    group.files.emplace_back(options.tls_key);
    if (!options.tls_client_ca.empty()) group.files.emplace_back(options.tls_client_ca);
  }
  if (!options.token_file.empty()) groups_.push_back({Kind::kTokens, {WatchedFile(options.token_file)}});
  if (!options.tls_client_names.empty()) {
    groups_.push_back({Kind::kClientNames, {WatchedFile(options.tls_client_names)}});
  }
}

absl::Status CredentialFiles::LoadAll() {
  for (Group& group : groups_) {
    for (WatchedFile& file : group.files) file.Changed();
    if (absl::Status status = Load(group); !status.ok()) return status;
  }
  return absl::OkStatus();
}

bool CredentialFiles::Refresh() {
  bool access_changed = false;
  for (Group& group : groups_) {
    bool changed = false;
    for (WatchedFile& file : group.files) changed |= file.Changed();
    if (!changed && !group.failed) continue;
    const absl::Status status = Load(group);
    group.failed = !status.ok();
    if (status.ok()) {
      access_changed |= group.kind != Kind::kCertificate;
      metrics_.CountReload(true);
      log_.Log(ServerLog::Level::kInfo, "reloaded", JsonLine().Add("file", group.files.front().path()));
    } else if (changed) {
      metrics_.CountReload(false);
      log_.Log(ServerLog::Level::kError, "reload_failed",
               JsonLine()
                   .Add("file", group.files.front().path())
                   .Add("message", absl::StrCat(status.message(), "; what was loaded before stays in force")));
    }
  }
  return access_changed;
}

absl::Status CredentialFiles::Load(const Group& group) {
  if (group.kind == Kind::kCertificate) return LoadCertificate(group);
  const std::string what =
      absl::StrCat(group.kind == Kind::kTokens ? "--token-file " : "--tls-client-names ", group.files.front().path());
  const absl::StatusOr<std::string> text = group.files.front().Read();
  if (!text.ok()) return Explain(text.status(), what);
  auto entries = group.kind == Kind::kTokens ? ParseTokenFile(*text) : ParseNameFile(*text);
  if (!entries.ok()) return Explain(entries.status(), what);
  if (group.kind == Kind::kTokens) {
    access_.SetTokens(*std::move(entries));
  } else {
    access_.SetCertificateNames(*std::move(entries));
  }
  return absl::OkStatus();
}

absl::Status CredentialFiles::LoadCertificate(const Group& group) {
  constexpr const char* kFlags[] = {"--tls-cert", "--tls-key", "--tls-client-ca"};
  std::string texts[3], what;
  for (size_t i = 0; i < group.files.size(); ++i) {
    absl::StrAppend(&what, i == 0 ? "" : ", ", kFlags[i], " ", group.files[i].path());
    absl::StatusOr<std::string> text = group.files[i].Read();
    if (!text.ok()) return Explain(text.status(), absl::StrCat(kFlags[i], " ", group.files[i].path()));
    if (text->empty())
      return absl::InvalidArgumentError(absl::StrCat(kFlags[i], " ", group.files[i].path(), ": empty"));
    texts[i] = *std::move(text);
  }
  absl::StatusOr<TlsIdentity> identity = MakeTlsIdentity(std::move(texts[0]), std::move(texts[1]), std::move(texts[2]));
  if (!identity.ok()) return Explain(identity.status(), what);
  const absl::Time now = absl::Now();
  if (identity->expires <= now && expires_ > now) {
    return absl::InvalidArgumentError(
        absl::StrCat(kFlags[0], " ", group.files.front().path(), ": the certificate ended at ",
                     absl::FormatTime(absl::RFC3339_sec, identity->expires, absl::UTCTimeZone())));
  }
  expires_ = identity->expires;
  metrics_.SetCertificateExpiry(identity->expires);
  if (identity->expires < now + kExpiryWarning) {
    log_.Log(ServerLog::Level::kWarning, "certificate_expires",
             JsonLine()
                 .Add("file", group.files.front().path())
                 .Add("expires", absl::FormatTime(absl::RFC3339_sec, identity->expires, absl::UTCTimeZone())));
  }
  if (tls_ == nullptr) {
    tls_ = std::make_unique<TlsCredentials>(*std::move(identity));
  } else {
    tls_->Replace(*std::move(identity));
  }
  return absl::OkStatus();
}

}  // namespace curvd
