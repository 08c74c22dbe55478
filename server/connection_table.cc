#include "server/connection_table.h"

#include <sys/stat.h>

namespace curvd {

void ConnectionTable::Add(int fd, const std::string& peer) {
  // The system gives a number out again only once its last owner has closed it.
  if (const auto closed = connections_.find(fd); closed != connections_.end()) Remove(closed);
  struct stat info = {};
  fstat(fd, &info);
  connections_.emplace(fd, Connection{info.st_dev, info.st_ino, peer});
  ++count_by_peer_[peer];
}

void ConnectionTable::Sweep() {
  for (auto next = connections_.begin(); next != connections_.end();) {
    const auto connection = next++;
    struct stat info = {};
    const bool open = fstat(connection->first, &info) == 0 && info.st_dev == connection->second.device &&
                      info.st_ino == connection->second.inode;
    if (!open) Remove(connection);
  }
}

size_t ConnectionTable::CountOf(const std::string& peer) const {
  const auto found = count_by_peer_.find(peer);
  return found == count_by_peer_.end() ? 0 : found->second;
}

void ConnectionTable::Remove(std::unordered_map<int, Connection>::iterator connection) {
  const auto count = count_by_peer_.find(connection->second.peer);
  if (--count->second == 0) count_by_peer_.erase(count);
  connections_.erase(connection);
}

}  // namespace curvd
