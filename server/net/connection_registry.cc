#include "server/net/connection_registry.h"

#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "server/net/listen_address.h"
#include "server/net/receive_valve.h"

namespace curvd {
namespace {

// All zero for a Unix socket, and what the system does not know.
tcp_info InfoOf(int fd) {
  tcp_info info = {};
  socklen_t length = sizeof(info);
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &length) != 0) return {};
  return info;
}

uint64_t ReceivedBytes(int fd) { return InfoOf(fd).tcpi_bytes_received; }

// Bytes that were received and that gRPC has not read.
uint64_t UnreadBytes(int fd) {
  int bytes = 0;
  return ioctl(fd, FIONREAD, &bytes) == 0 ? static_cast<uint64_t>(std::max(0, bytes)) : 0;
}

}  // namespace

ConnectionRegistry::~ConnectionRegistry() { Clear(); }

int ConnectionRegistry::Add(int fd, const std::string& peer) {
  const int watch = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (watch < 0) return -1;
  const auto now = std::chrono::steady_clock::now();
  Connection connection = {{}, ByteAccount(allowances_, now), BeginningOf(watch)};
  connection.record.peer = peer;
  connection.record.accepted = now;
  MutexLock lock(mutex_);
  MoveBound(watch, connection);
  connections_.emplace(watch, std::move(connection));
  watch_of_peer_[peer] = watch;
  ++count_by_address_[PeerAddress(peer)];
  return watch;
}

ConnectionRecord ConnectionRegistry::Remove(int watch) {
  MutexLock lock(mutex_);
  const auto connection = connections_.find(watch);
  strangers_bytes_ -= StrangersBytesOf(connection->second);
  ConnectionRecord record = std::move(connection->second.record);
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
  for (const auto& [watch, connection] : connections_) close(watch);
  connections_.clear();
  watch_of_peer_.clear();
  count_by_address_.clear();
  strangers_bytes_ = 0;
}

void ConnectionRegistry::NoteCall(const std::string& peer, Call call, uint64_t metadata) {
  MutexLock lock(mutex_);
  Connection* connection = Find(peer);
  if (connection == nullptr) return;
  if (connection->account.TooMuchMetadata(metadata)) {
    End(watch_of_peer_.at(peer), *connection, StrangerReason::kTooMuchMetadata);
  }
  switch (call) {
    case Call::kLetIn:
      ++connection->record.let_in_calls;
      strangers_bytes_ -= StrangersBytesOf(*connection);
      connection->account.NoteLetIn();
      if (std::exchange(connection->beginning, std::nullopt).has_value()) LiftBound(watch_of_peer_.at(peer));
      return;
    case Call::kRefused:
      ++connection->record.refused_calls;
      return;
    case Call::kOpenToAll:
      ++connection->record.open_calls;
      connection->account.NoteOpenToAll();
      return;
  }
}

void ConnectionRegistry::NoteMessage(const std::string& peer, uint64_t bytes, bool is_first) {
  MutexLock lock(mutex_);
  Connection* connection = Find(peer);
  if (connection == nullptr) return;
  connection->record.let_in_bytes += bytes;
  connection->account.NoteMessage(bytes, is_first);
}

void ConnectionRegistry::NoteSent(const std::string& peer, uint64_t bytes) {
  MutexLock lock(mutex_);
  if (Connection* connection = Find(peer)) connection->account.NoteSent(bytes);
}

void ConnectionRegistry::NoteOpenToAllEnd(const std::string& peer) {
  MutexLock lock(mutex_);
  if (Connection* connection = Find(peer)) connection->account.NoteOpenToAllEnd();
}

void ConnectionRegistry::NoteAnswered(const std::string& peer, uint64_t metadata) {
  MutexLock lock(mutex_);
  if (Connection* connection = Find(peer)) connection->account.NoteAnswered(metadata);
}

void ConnectionRegistry::NoteEnd(const std::string& peer, const EndedCall& call) {
  MutexLock lock(mutex_);
  if (Connection* connection = Find(peer)) connection->account.NoteEnd(call);
}

ConnectionRegistry::Sight ConnectionRegistry::Look(int watch, ByteAccount::Clock::time_point now) {
  MutexLock lock(mutex_);
  Connection& connection = connections_.at(watch);
  const tcp_info info = InfoOf(watch);
  const uint64_t received = info.tcpi_bytes_received;
  const uint64_t unread = std::min(received, UnreadBytes(watch));
  const bool more = received != std::exchange(connection.record.received_bytes, received);
  const ByteAccount::Verdict verdict =
      connection.account.Judge(received - unread, info.tcpi_bytes_sent - info.tcpi_bytes_retrans, now);
  strangers_bytes_ -= StrangersBytesOf(connection);
  connection.unaccounted = connection.account.unaccounted() + unread;
  strangers_bytes_ += StrangersBytesOf(connection);
  if (connection.record.closed_for.has_value()) return Sight::kQuiet;
  if (verdict == ByteAccount::Verdict::kTooMuch || connection.was_full) {
    End(watch, connection, StrangerReason::kUnaccountedBytes);
    return Sight::kEnded;
  }
  MoveBound(watch, connection);
  // gRPC may not have read all of what lets a connection be a suspect.
  const bool full = connection.beginning.has_value() && received >= connection.bound;
  if (more || full || verdict == ByteAccount::Verdict::kSuspect) return Sight::kBusy;
  return verdict == ByteAccount::Verdict::kOwes ? Sight::kOwes : Sight::kQuiet;
}

bool ConnectionRegistry::HasMore(int watch) const {
  MutexLock lock(mutex_);
  return ReceivedBytes(watch) != connections_.at(watch).record.received_bytes;
}

bool ConnectionRegistry::IsStranger(int watch) const {
  MutexLock lock(mutex_);
  return !connections_.at(watch).account.let_in();
}

uint64_t ConnectionRegistry::StrangersBytes() const {
  MutexLock lock(mutex_);
  return strangers_bytes_;
}

uint64_t ConnectionRegistry::BytesBeyond(uint64_t spared, const Connection& connection) {
  if (connection.account.let_in() || connection.record.closed_for.has_value()) return 0;
  return connection.unaccounted - std::min(spared, connection.unaccounted);
}

uint64_t ConnectionRegistry::StrangersBytesOf(const Connection& connection) const {
  return BytesBeyond(allowances_.first_flight(), connection);
}

bool ConnectionRegistry::EndLargestStranger() {
  MutexLock lock(mutex_);
  int largest = -1;
  uint64_t least = 0;
  for (const auto& [watch, connection] : connections_) {
    const uint64_t bytes = BytesBeyond(kSparedBytes, connection);
    if (bytes <= least) continue;
    least = bytes;
    largest = watch;
  }
  if (largest < 0) return false;
  End(largest, connections_.at(largest), StrangerReason::kMemoryShort);
  return true;
}

bool ConnectionRegistry::EndStrangersBeyond(uint64_t together) {
  MutexLock lock(mutex_);
  std::vector<std::pair<uint64_t, int>> strangers;  // bytes and watch
  uint64_t sum = 0;
  for (const auto& [watch, connection] : connections_) {
    const uint64_t bytes = BytesBeyond(0, connection);
    strangers.emplace_back(bytes, watch);
    sum += bytes;
  }
  if (sum <= together) return false;
  std::sort(strangers.begin(), strangers.end(), std::greater<>());
  for (const auto& [bytes, watch] : strangers) {
    if (sum <= together) break;
    End(watch, connections_.at(watch), StrangerReason::kMemoryShort);
    sum -= bytes;
  }
  return true;
}

bool ConnectionRegistry::EndLargestLetIn(uint64_t least) {
  MutexLock lock(mutex_);
  int largest = -1;
  for (const auto& [watch, connection] : connections_) {
    if (!connection.account.let_in() || connection.record.closed_for.has_value()) continue;
    if (connection.account.unaccounted() <= least) continue;
    least = connection.account.unaccounted();
    largest = watch;
  }
  if (largest < 0) return false;
  End(largest, connections_.at(largest), StrangerReason::kMemoryShort);
  return true;
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
  for (const auto& [watch, connection] : connections_) {
    open.emplace_back(connection.record).received_bytes = ReceivedBytes(watch);
  }
  return open;
}

bool ConnectionRegistry::ShutDown(const std::string& peer) {
  MutexLock lock(mutex_);
  const auto latest = watch_of_peer_.find(peer);
  return latest != watch_of_peer_.end() && shutdown(latest->second, SHUT_RDWR) == 0;
}

void ConnectionRegistry::End(int watch, Connection& connection, StrangerReason reason) {
  if (connection.record.closed_for.has_value()) return;
  strangers_bytes_ -= StrangersBytesOf(connection);
  connection.record.closed_for = reason;
  shutdown(watch, SHUT_RDWR);
  // The system resets a connection that was shut down when more comes: the peer shall hear of it.
  if (std::exchange(connection.beginning, std::nullopt).has_value()) LiftBound(watch);
  // Else gRPC would still read what waits.
  constexpr size_t kAll = size_t{1} << 30;
  recv(watch, nullptr, kAll, MSG_TRUNC | MSG_DONTWAIT);
}

void ConnectionRegistry::MoveBound(int watch, Connection& connection) {
  const uint64_t bound = connection.account.bound();
  if (!connection.beginning.has_value() || bound < connection.bound + ByteAccount::kBoundStep) return;
  if (!BoundReceived(watch, *connection.beginning, bound)) connection.beginning.reset();
  if (connection.bound != 0 && connection.record.received_bytes >= connection.bound) connection.was_full = true;
  connection.bound = bound;
}

ConnectionRegistry::Connection* ConnectionRegistry::Find(const std::string& peer) {
  const auto latest = watch_of_peer_.find(peer);
  return latest == watch_of_peer_.end() ? nullptr : &connections_.at(latest->second);
}

}  // namespace curvd
