#include "server/access/access_table.h"

#include <utility>

namespace curvd {

AccessTable::AccessTable(std::vector<AccessEntry> entries) : entries_(std::move(entries)) {
  by_hash_.reserve(entries_.size());
  by_name_.reserve(entries_.size());
  for (const AccessEntry& entry : entries_) {
    by_hash_[entry.token_hash] = &entry;
    by_name_.emplace(entry.name, &entry);
  }
}

const AccessEntry* AccessTable::FindHash(const Sha256& hash) const {
  const auto found = by_hash_.find(hash);
  return found == by_hash_.end() ? nullptr : found->second;
}

const AccessEntry* AccessTable::FindName(const std::vector<std::string>& names) const {
  const AccessEntry* first = nullptr;
  for (const std::string& name : names) {
    const auto found = by_name_.find(name);
    if (found != by_name_.end() && (first == nullptr || found->second < first)) first = found->second;
  }
  return first;
}

}  // namespace curvd
