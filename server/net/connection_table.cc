#include "server/net/connection_table.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "server/net/listen_address.h"

namespace curvd {
namespace {

// Whether `fd` is a TCP socket that can no longer send.
bool IsShutDown(int fd) {
  tcp_info info = {};
  socklen_t length = sizeof(info);
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &length) != 0) return false;
  return info.tcpi_state != TCP_ESTABLISHED && info.tcpi_state != TCP_CLOSE_WAIT;
}

}  // namespace

void ConnectionTable::Add(int fd, const std::string& peer) {
  // The system gives a number out again only once its last owner has closed it.
  if (const auto closed = connections_.find(fd); closed != connections_.end()) Remove(closed);
  struct stat info = {};
  fstat(fd, &info);
  connections_.emplace(fd, Connection{info.st_dev, info.st_ino, peer});
  ++count_by_address_[PeerAddress(peer)];
}

void ConnectionTable::Sweep() {
  for (auto next = connections_.begin(); next != connections_.end();) {
    const auto connection = next++;
    if (!IsOpen(connection->first, connection->second)) Remove(connection);
  }
}

size_t ConnectionTable::CountOf(const std::string& address) const {
  const auto found = count_by_address_.find(address);
  return found == count_by_address_.end() ? 0 : found->second;
}

std::string ConnectionTable::PeerBeingClosed() const {
  std::string peer;
  for (const auto& [fd, connection] : connections_) {
    if (!IsShutDown(fd) || !IsOpen(fd, connection)) continue;
    if (!peer.empty()) return "";
    peer = connection.peer;
  }
  return peer;
}

bool ConnectionTable::IsOpen(int fd, const Connection& connection) {
  struct stat info = {};
  return fstat(fd, &info) == 0 && info.st_dev == connection.device && info.st_ino == connection.inode;
}

void ConnectionTable::Remove(std::unordered_map<int, Connection>::iterator connection) {
  const auto count = count_by_address_.find(PeerAddress(connection->second.peer));
  if (--count->second == 0) count_by_address_.erase(count);
  connections_.erase(connection);
}

}  // namespace curvd
