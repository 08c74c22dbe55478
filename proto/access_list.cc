#include "proto/access_list.h"

#include <openssl/sha.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "proto/open_ssl.h"

namespace curvd {
namespace {

constexpr char kHashPrefix[] = "sha256:";
constexpr size_t kMaxNameBytes = 128;

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

// Names go to the log: plain, short words.
bool IsName(absl::string_view word) {
  if (word.size() > kMaxNameBytes) return false;
  for (const char c : word) {
    if (c <= ' ' || c > '~' || c == '"') return false;
  }
  return !word.empty();
}

bool ParseHash(absl::string_view word, Sha256& hash) {
  if (!absl::ConsumePrefix(&word, kHashPrefix) || word.size() != 2 * hash.size()) return false;
  for (const char c : word) {
    if (!absl::ascii_isxdigit(static_cast<unsigned char>(c))) return false;
  }
  const std::string bytes = absl::HexStringToBytes(word);
  std::copy(bytes.begin(), bytes.end(), hash.begin());
  return true;
}

// "max-streams=4" or "max-points=1000000". Returns what is wrong, or "".
std::string ParseLimit(absl::string_view word, AccessEntry& entry) {
  absl::string_view number = word;
  if (absl::ConsumePrefix(&number, "max-streams=")) {
    return absl::SimpleAtoi(number, &entry.max_streams) && entry.max_streams > 0 ? "" : "max-streams must be 1 or more";
  }
  if (absl::ConsumePrefix(&number, "max-points=")) {
    return absl::SimpleAtoi(number, &entry.max_points) && entry.max_points > 0 ? "" : "max-points must be 1 or more";
  }
  return "only max-streams=N and max-points=N may follow";
}

std::string ParseLine(absl::string_view line, bool with_hash, AccessEntry& entry) {
  const std::vector<absl::string_view> words = absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
  if (!IsName(words[0])) return "the name must be at most 128 printable ASCII characters without quotes";
  entry.name = std::string(words[0]);
  size_t next = 1;
  if (with_hash && (words.size() < 2 || !ParseHash(words[next++], entry.token_hash))) {
    return "after the name must come sha256: and the 64 hexadecimal digits of the token's hash";
  }
  for (; next < words.size(); ++next) {
    if (std::string wrong = ParseLimit(words[next], entry); !wrong.empty()) return wrong;
  }
  return "";
}

absl::StatusOr<std::vector<AccessEntry>> Parse(std::string_view text, bool with_hash) {
  std::vector<AccessEntry> entries;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(View(text), '\n')) {
    ++number;
    const absl::string_view stripped = absl::StripAsciiWhitespace(line);
    if (stripped.empty() || stripped[0] == '#') continue;
    AccessEntry& entry = entries.emplace_back();
    if (const std::string wrong = ParseLine(stripped, with_hash, entry); !wrong.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("line ", number, ": ", wrong));
    }
  }
  return entries;
}

}  // namespace

Sha256 HashToken(std::string_view token) {
  KeepOpenSslAtExit();
  Sha256 hash;
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  return hash;
}

std::string FormatHash(const Sha256& hash) {
  return absl::StrCat(
      kHashPrefix, absl::BytesToHexString(absl::string_view(reinterpret_cast<const char*>(hash.data()), hash.size())));
}

absl::StatusOr<std::vector<AccessEntry>> ParseTokenFile(std::string_view text) { return Parse(text, true); }
absl::StatusOr<std::vector<AccessEntry>> ParseNameFile(std::string_view text) { return Parse(text, false); }

}  // namespace curvd
