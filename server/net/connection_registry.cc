#include "server/net/connection_registry.h"

#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include "server/net/listen_address.h"

namespace curvd {
namespace {

uint64_t ReceivedBytes(int fd) {
  tcp_info info = {};
  socklen_t length = sizeof(info);
  return getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &length) == 0 ? info.tcpi_bytes_received : 0;
}

}  // namespace

ConnectionRegistry::~ConnectionRegistry() { Clear(); }

int ConnectionRegistry::Add(int fd, const std::string& peer) {
  const int watch = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (watch < 0) return -1;
  ConnectionRecord record;
  record.peer = peer;
  record.accepted = std::chrono::steady_clock::now();
  MutexLock lock(mutex_);
  connections_.emplace(watch, std::move(record));
  watch_of_peer_[peer] = watch;
  ++count_by_address_[PeerAddress(peer)];
  return watch;
}

ConnectionRecord ConnectionRegistry::Remove(int watch) {
  MutexLock lock(mutex_);
  const auto connection = connections_.find(watch);
  ConnectionRecord record = std::move(connection->second);
  connections_.erase(connection);
  const auto latest = watch_of_peer_.find(record.peer);
  if (latest != watch_of_peer_.end() && latest->second == watch) watch_of_peer_.erase(latest);
  const auto count = count_by_address_.find(PeerAddress(record.peer));
  if (--count->second == 0) count_by_address_.erase(count);
  record.received_bytes = ReceivedBytes(watch);
  close(watch);
  return record;
}

void ConnectionRegistry::Clear() {
  MutexLock lock(mutex_);
  for (const auto& [watch, record] : connections_) close(watch);
  connections_.clear();
  watch_of_peer_.clear();
  count_by_address_.clear();
}

void ConnectionRegistry::NoteCall(const std::string& peer, Call call) {
  MutexLock lock(mutex_);
  ConnectionRecord* connection = Find(peer);
  if (connection == nullptr) return;
  switch (call) {
    case Call::kLetIn:
      ++connection->let_in_calls;
      return;
    case Call::kRefused:
      ++connection->refused_calls;
      return;
    case Call::kOpenToAll:
      ++connection->open_calls;
      return;
  }
}

void ConnectionRegistry::NoteMessage(const std::string& peer, uint64_t bytes) {
  MutexLock lock(mutex_);
  if (ConnectionRecord* connection = Find(peer)) connection->let_in_bytes += bytes;
}

size_t ConnectionRegistry::size() const {
  MutexLock lock(mutex_);
  return connections_.size();
}

size_t ConnectionRegistry::CountFrom(const std::string& address) const {
  MutexLock lock(mutex_);
  const auto found = count_by_address_.find(address);
  return found == count_by_address_.end() ? 0 : found->second;
}

std::vector<ConnectionRecord> ConnectionRegistry::Open() const {
  std::vector<ConnectionRecord> open;
  MutexLock lock(mutex_);
  open.reserve(connections_.size());
  for (const auto& [watch, record] : connections_) open.emplace_back(record).received_bytes = ReceivedBytes(watch);
  return open;
}

bool ConnectionRegistry::ShutDown(const std::string& peer) {
  MutexLock lock(mutex_);
  const auto latest = watch_of_peer_.find(peer);
  return latest != watch_of_peer_.end() && shutdown(latest->second, SHUT_RDWR) == 0;
}

ConnectionRecord* ConnectionRegistry::Find(const std::string& peer) {
  const auto latest = watch_of_peer_.find(peer);
  return latest == watch_of_peer_.end() ? nullptr : &connections_.at(latest->second);
}

}  // namespace curvd
