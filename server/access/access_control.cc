#include "server/access/access_control.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "server/net/listen_address.h"
#include "server/rpc/error_detail.h"
#include "server/rpc/error_reasons.h"

namespace curvd {
namespace {

constexpr char kSendToken[] = "metadata \"authorization: Bearer TOKEN\" (curv: --token-file)";

absl::Status TokenMissing(const char* what) {
  return WithDetail(absl::UnauthenticatedError(absl::StrCat(what, "; this server asks for ", kSendToken)),
                    {kReasonTokenMissing, "authorization", "", "Bearer TOKEN", {}});
}

absl::Status TokenInvalid() {
  return WithDetail(absl::UnauthenticatedError("the bearer token is not one that this server knows, or no longer"),
                    {kReasonTokenInvalid, "authorization", "", "a token that the server knows", {}});
}

// What a refusal shows of a certificate's names, which may be thousands, and whose bytes a caller gets three times, of
// 8 KiB that it takes.
constexpr size_t kShownNameBytes = 512;

// Whole names, as many as kShownNameBytes hold; of a longer one its beginning. Says what is left out.
std::string ShownNames(const std::vector<std::string>& names) {
  const std::string all = absl::StrJoin(names, ", ");
  if (all.size() <= kShownNameBytes) return all;
  std::string shown;
  for (const std::string& name : names) {
    const size_t with_comma = (shown.empty() ? 0 : shown.size() + 2) + name.size();
    if (with_comma > kShownNameBytes) break;
    absl::StrAppend(&shown, shown.empty() ? "" : ", ", name);
  }
  if (shown.empty()) shown = names.front().substr(0, kShownNameBytes);
  return absl::StrCat(shown, "... (", kShownNameBytes, " of ", all.size(), " bytes at most are shown, of ",
                      names.size(), names.size() == 1 ? " name)" : " names)");
}

absl::Status ClientNotAllowed(const std::string& names) {
  return WithDetail(
      absl::PermissionDeniedError(absl::StrCat("the client certificate names ", names.empty() ? "nobody" : names,
                                               "; this server lets in other names only")),
      {kReasonClientNotAllowed, "client certificate", names, "a name that the server lets in", {}});
}

absl::StatusOr<std::string_view> TokenIn(const std::optional<std::string>& authorization) {
  if (!authorization.has_value()) return TokenMissing("the call carries no token");
  absl::string_view token = *authorization;
  // RFC 7235: the scheme's case does not matter.
  if (!absl::StartsWithIgnoreCase(token, "Bearer ")) return TokenMissing("authorization is no bearer token");
  token.remove_prefix(7);
  token = absl::StripAsciiWhitespace(token);
  return std::string_view(token.data(), token.size());
}

void Tighten(const AccessEntry& entry, Caller& caller) {
  if (entry.max_streams != 0) {
    caller.max_streams = caller.max_streams == 0 ? entry.max_streams : std::min(caller.max_streams, entry.max_streams);
  }
  if (entry.max_points != 0) {
    caller.max_points = caller.max_points == 0 ? entry.max_points : std::min(caller.max_points, entry.max_points);
  }
}

}  // namespace

// A long table is neither made nor destroyed while calls wait for the lock: the old one dies with `fresh`.
void AccessControl::SetTokens(std::vector<AccessEntry> tokens) {
  Table fresh = std::make_shared<const AccessTable>(std::move(tokens));
  MutexLock lock(mutex_);
  tokens_.swap(fresh);
}

void AccessControl::SetCertificateNames(std::vector<AccessEntry> names) {
  Table fresh = std::make_shared<const AccessTable>(std::move(names));
  MutexLock lock(mutex_);
  names_.swap(fresh);
}

AccessControl::Tables AccessControl::CurrentTables() const {
  MutexLock lock(mutex_);
  return {tokens_, names_};
}

absl::StatusOr<Caller> AccessControl::Identify(const PresentedCredentials& presented) const {
  const auto [tokens, names] = CurrentTables();
  Caller caller;
  caller.name = presented.certificate_names.empty() ? PeerAddress(presented.peer) : presented.certificate_names.front();
  if (names != nullptr) {
    const AccessEntry* entry = names->FindName(presented.certificate_names);
    if (entry == nullptr) return ClientNotAllowed(ShownNames(presented.certificate_names));
    caller.name = caller.certificate_name = entry->name;
    Tighten(*entry, caller);
  }
  if (tokens != nullptr) {
    const absl::StatusOr<std::string_view> token = TokenIn(presented.authorization);
    if (!token.ok()) return token.status();
    const AccessEntry* entry = tokens->FindHash(HashToken(*token));
    if (entry == nullptr) return TokenInvalid();
    caller.name = entry->name;
    caller.token_hash = entry->token_hash;
    Tighten(*entry, caller);
  }
  return caller;
}

absl::Status AccessControl::Recheck(const Caller& caller) const {
  const auto [tokens, names] = CurrentTables();
  if (names != nullptr && names->FindName({caller.certificate_name}) == nullptr) {
    return ClientNotAllowed(caller.certificate_name);
  }
  if (tokens == nullptr) return absl::OkStatus();
  const bool known = caller.token_hash.has_value() && tokens->FindHash(*caller.token_hash) != nullptr;
  return known ? absl::OkStatus() : TokenInvalid();
}

}  // namespace curvd
