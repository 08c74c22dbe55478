// Reads any text as a file of tokens and as a file of names.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/access_list.h"
#include "server/access/access_table.h"
#include "tests/fuzz/require.h"

namespace {

using curvd::AccessEntry;

// Somebody may have put a token where a name or a hash belongs.
constexpr size_t kSecretBytes = 32;

// Whether `message` holds a word of `text` that is long enough to be a token.
bool TellsASecret(std::string_view message, std::string_view text) {
  size_t begin = 0;
  while (begin < text.size()) {
    const size_t end = std::min(text.find_first_of(" \t\r\n", begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    if (word.size() >= kSecretBytes && message.find(word) != std::string_view::npos) return true;
    begin = end + 1;
  }
  return false;
}

void Check(const absl::StatusOr<std::vector<AccessEntry>>& entries, std::string_view text) {
  if (entries.ok()) {
    for (const AccessEntry& entry : *entries) fuzz::Require(fuzz::IsShowable(entry.name), "names are printable");
    return;
  }
  fuzz::Require(absl::IsInvalidArgument(entries.status()), "errors are INVALID_ARGUMENT");
  const std::string message(entries.status().message());
  fuzz::Require(fuzz::IsShowable(message), "messages are printable");
  fuzz::Require(!TellsASecret(message, text), "messages tell no secret");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  Check(curvd::ParseNameFile(text), text);
  const absl::StatusOr<std::vector<AccessEntry>> tokens = curvd::ParseTokenFile(text);
  Check(tokens, text);
  if (!tokens.ok()) return 0;
  const std::string token(text.substr(0, 64));
  const curvd::AccessTable table(*tokens);
  const AccessEntry* entry = table.FindHash(curvd::HashToken(token));
  fuzz::Require(entry == nullptr || entry->token_hash == curvd::HashToken(token), "only its own hash admits a token");
  return 0;
}
