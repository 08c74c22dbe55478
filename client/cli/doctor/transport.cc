#include "client/cli/doctor/transport.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "client/cli/doctor/greeting.h"
#include "client/cli/doctor/tls_handshake.h"
#include "client/io/text.h"

namespace curv {
namespace {

constexpr char kOtherPort[] =
    "ask the port of curvd's --listen (50061 unless it says otherwise), not that of its metrics (9461) or of another "
    "service";

std::string DayOf(absl::Time time) { return absl::FormatTime("%Y-%m-%d %H:%M UTC", time, absl::UTCTimeZone()); }

// Adds what is wrong with an address at which plain text was tried and HTTP/2 did not come back.
void ExplainPlainText(Greeting greeting, const Address& address, const std::string& host, const std::string& prefix,
                      const ExamineOptions& options, Findings& findings) {
  const auto fault = [&](const char* says, const char* remedy) {
    findings.Fault("protocol", absl::StrCat(prefix, says), remedy);
  };
  if (greeting == Greeting::kHttp1) return fault("speaks HTTP/1, which no gRPC goes over", kOtherPort);
  if (ShakeHands(address, host, options.connect, options.timeout).ok()) {
    return fault("speaks TLS only, and was asked in plain text",
                 "add --tls, and --ca FILE if its authority is your own");
  }
  switch (greeting) {
    case Greeting::kClosed:
      return fault("closes connections without a word",
                   "look into the log of curvd: it may have as many connections as it takes");
    case Greeting::kSilence:
      return fault("takes connections and says nothing",
                   "look whether the process hangs, or waits for memory; else ask another port");
    default:
      return fault("speaks neither HTTP/2 nor TLS", kOtherPort);
  }
}

// Adds what is wrong with an address at which TLS was tried and no handshake came about.
void ExplainNoHandshake(const absl::Status& status, const Address& address, const std::string& prefix,
                        const ExamineOptions& options, Findings& findings) {
  const absl::StatusOr<Greeting> greeting = GreetInPlainText(address, options.timeout);
  if (greeting.ok() && *greeting == Greeting::kHttp2) {
    findings.Fault("protocol", absl::StrCat(prefix, "speaks plain text, and was asked for TLS"),
                   "leave out --tls, --ca and --cert, or give curvd a certificate (--tls-cert, --tls-key)");
  } else if (greeting.ok() && *greeting == Greeting::kHttp1) {
    findings.Fault("protocol", absl::StrCat(prefix, "speaks HTTP/1 in plain text"), kOtherPort);
  } else {
    findings.Fault("protocol", absl::StrCat(prefix, "no TLS came about: ", status.message()),
                   "if it asks for a client certificate, give --cert and --key; else look into the log of curvd");
  }
}

// Returns whether the certificate's dates are good by this machine's clock.
bool CheckDates(const TlsHandshake& tls, const std::string& prefix, Findings& findings) {
  constexpr absl::Duration kSoon = absl::Hours(14 * 24);
  const absl::Time now = absl::Now();
  if (now > tls.not_after || now < tls.not_before) {
    const bool is_over = now > tls.not_after;
    findings.Fault(
        "certificate",
        absl::StrCat(prefix, is_over ? "expired at " : "is not valid before ",
                     DayOf(is_over ? tls.not_after : tls.not_before), "; this machine's clock says ", DayOf(now)),
        is_over ? "renew it: curvd takes new files of --tls-cert and --tls-key while it runs; or set the clock right"
                : "set the clock right, of this machine or of the one that made the certificate");
    return false;
  }
  const int64_t days = absl::ToInt64Hours(tls.not_after - now) / 24;
  const std::string says = absl::StrCat(prefix, "valid until ", DayOf(tls.not_after), ", ", days, " days from now");
  if (tls.not_after - now < kSoon) {
    findings.Warn("certificate", says,
                  "renew it soon: curvd takes new files of --tls-cert and --tls-key while it runs");
  } else {
    findings.Ok("certificate", says);
  }
  return true;
}

bool CheckName(const TlsHandshake& tls, const std::string& name, const std::string& prefix, Findings& findings) {
  const std::string names =
      tls.names.empty() ? "no name" : absl::StrJoin(tls.names, ", ", [](std::string* out, const std::string& each) {
        absl::StrAppend(out, Printable(each));
      });
  if (tls.fits_name) {
    findings.Ok("name", absl::StrCat(prefix, "the certificate is for ", names));
    return true;
  }
  findings.Fault(
      "name", absl::StrCat(prefix, "the certificate is for ", names, ", not for ", name),
      "name the server as the certificate does, in --server or with --server-name; or have one made for this name");
  return false;
}

bool CheckAuthority(const TlsHandshake& tls, const ExamineOptions& options, const std::string& prefix,
                    Findings& findings) {
  if (tls.distrust.empty()) {
    findings.Ok("authority", absl::StrCat(prefix, "trusted: ", tls.issuer));
    return true;
  }
  findings.Fault("authority",
                 absl::StrCat(prefix, "not trusted (", tls.distrust, "): ", tls.subject, ", issued by ", tls.issuer),
                 options.connect.authorities.empty()
                     ? "give the certificate of the authority that issued it: --ca FILE"
                     : "--ca names other authorities than the one that issued it: give that one's certificate");
  return false;
}

// Returns whether the server is content with the certificate that was shown, or with none.
bool CheckOwnCertificate(const TlsHandshake& tls, const ExamineOptions& options, const std::string& prefix,
                         Findings& findings) {
  const bool was_shown = !options.connect.certificate.empty();
  if (!tls.complaint.empty()) {
    findings.Fault(
        "client",
        absl::StrCat(prefix,
                     was_shown ? "the server refuses the certificate of --cert: " : "the server ends the connection: ",
                     tls.complaint),
        !tls.asks_for_certificate ? "look into the log of curvd"
        : was_shown ? "give one of an authority that curvd's --tls-client-ca names, and that has not expired"
                    : "it asks for a client certificate: give --cert and --key");
    return false;
  }
  if (tls.asks_for_certificate) {
    findings.Ok("client", absl::StrCat(prefix, "the server asks for a certificate, and takes ",
                                       was_shown ? "that of --cert" : "none as well"));
  }
  return true;
}

bool LookAtTls(const Address& address, const std::string& host, const std::string& prefix,
               const ExamineOptions& options, Findings& findings) {
  const std::string& name = options.connect.server_name.empty() ? host : options.connect.server_name;
  const absl::StatusOr<TlsHandshake> tls = ShakeHands(address, name, options.connect, options.timeout);
  if (absl::IsInvalidArgument(tls.status())) {
    findings.Fault("client", std::string(tls.status().message()), "give files of PEM that belong together");
    return false;
  }
  if (!tls.ok()) {
    ExplainNoHandshake(tls.status(), address, prefix, options, findings);
    return false;
  }
  if (!tls->speaks_http2) {
    findings.Fault("protocol", absl::StrCat(prefix, tls->version, ", but no HTTP/2 within it"), kOtherPort);
    return false;
  }
  findings.Ok("protocol", absl::StrCat(prefix, "HTTP/2 in ", tls->version));
  // All of them are told, not the first alone.
  const bool dates = CheckDates(*tls, prefix, findings);
  const bool fits = CheckName(*tls, name, prefix, findings);
  const bool trusted = CheckAuthority(*tls, options, prefix, findings);
  const bool content = CheckOwnCertificate(*tls, options, prefix, findings);
  return dates && fits && trusted && content;
}

}  // namespace

bool LookAtTransport(const Address& address, const std::string& host, const std::string& prefix,
                     const ExamineOptions& options, Findings& findings) {
  if (options.connect.tls) return LookAtTls(address, host, prefix, options, findings);
  const absl::StatusOr<Greeting> greeting = GreetInPlainText(address, options.timeout);
  if (!greeting.ok()) {
    findings.Fault("protocol", absl::StrCat(prefix, "takes no second connection: ", greeting.status().message()),
                   "look into the log of curvd: it may have as many connections as it takes");
    return false;
  }
  if (*greeting == Greeting::kHttp2) {
    findings.Ok("protocol", absl::StrCat(prefix, "HTTP/2 in plain text"));
    return true;
  }
  ExplainPlainText(*greeting, address, host, prefix, options, findings);
  return false;
}

}  // namespace curv
