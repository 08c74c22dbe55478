// Finds who may call in a list that may be long.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/access_list.h"

namespace curvd {

// The entries of a file of tokens or names. A look-up takes as long whatever their number. How long it takes may tell
// whoever guesses how many bits the hash of the guess has in common with a hash of the list, but as nobody can choose
// the hash of a guess, that does not lead to a token. Immutable, so thread-safe.
class AccessTable {
 public:
  explicit AccessTable(std::vector<AccessEntry> entries);
  AccessTable(const AccessTable&) = delete;
  AccessTable& operator=(const AccessTable&) = delete;

  // The entry of the token with this hash, or null. Of several the last.
  const AccessEntry* FindHash(const Sha256& hash) const;
  // The first entry of the file that has one of `names`, or null.
  const AccessEntry* FindName(const std::vector<std::string>& names) const;

 private:
  struct FirstBytes {
    size_t operator()(const Sha256& hash) const {
      size_t first = 0;
      std::memcpy(&first, hash.data(), sizeof(first));
      return first;
    }
  };

  const std::vector<AccessEntry> entries_;
  std::unordered_map<Sha256, const AccessEntry*, FirstBytes> by_hash_;
  std::unordered_map<std::string_view, const AccessEntry*> by_name_;  // the names are those of entries_
};

}  // namespace curvd
