#include "server/net/connection_registry.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "server/net/listen_address.h"
#include "server/net/tcp_counts.h"

namespace curvd {
ConnectionRegistry::~ConnectionRegistry() { Clear(); }

std::optional<ConnectionRegistry::Added> ConnectionRegistry::Add(int fd, const std::string& peer) {
  const int watch = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (watch < 0) return std::nullopt;
  const auto now = std::chrono::steady_clock::now();
  Connection connection = {{}, ByteAccount(allowances_, now)};
  connection.record.peer = peer;
  connection.record.accepted = now;
  MutexLock lock(mutex_);
  const bool may_enter = rations_.Add(watch, now);
  connections_.emplace(watch, std::move(connection));
  watch_of_peer_[peer] = watch;
  ++count_by_address_[PeerAddress(peer)];
  return Added{watch, may_enter};
}

ConnectionRecord ConnectionRegistry::Remove(int watch) {
  MutexLock lock(mutex_);
  const auto connection = connections_.find(watch);
  rations_.End(watch, std::chrono::steady_clock::now());
  ConnectionRecord record = std::move(connection->second.record);
  connections_.erase(connection);
  const auto latest = watch_of_peer_.find(record.peer);
  if (latest != watch_of_peer_.end() && latest->second == watch) watch_of_peer_.erase(latest);
  const auto count = count_by_address_.find(PeerAddress(record.peer));
  if (--count->second == 0) count_by_address_.erase(count);
  record.received_bytes = CountsOf(watch).received;
  close(watch);
  return record;
}

void ConnectionRegistry::Clear() {
  MutexLock lock(mutex_);
  for (const auto& [watch, connection] : connections_) {
    rations_.Lift(watch);
    close(watch);
  }
  connections_.clear();
  watch_of_peer_.clear();
  count_by_address_.clear();
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
      connection->account.NoteLetIn();
      rations_.Lift(watch_of_peer_.at(peer));
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
  const auto [received, sent] = CountsOf(watch);
  const uint64_t unread = std::min(received, UnreadBytes(watch));
  const bool more = received != std::exchange(connection.record.received_bytes, received);
  const ByteAccount::Verdict verdict = connection.account.Judge(received - unread, sent, now);
  connection.unaccounted = connection.account.unaccounted() + unread;
  if (connection.record.closed_for.has_value()) return Sight::kQuiet;
  const StrangerRations::Use use =
      rations_.Note(watch, received, received - unread, connection.account.accounted(), now);
  if (verdict == ByteAccount::Verdict::kTooMuch || use == StrangerRations::Use::kTooMuch) {
    End(watch, connection, StrangerReason::kUnaccountedBytes);
    return Sight::kEnded;
  }
  // gRPC may not have read all of what lets a connection be a suspect, and nobody tells when it reads what a stranger
  // sent.
  const bool reads_later = unread > 0 && !connection.account.let_in();
  if (more || reads_later || use == StrangerRations::Use::kAll || verdict == ByteAccount::Verdict::kSuspect) {
    return Sight::kBusy;
  }
  return verdict == ByteAccount::Verdict::kOwes ? Sight::kOwes : Sight::kQuiet;
}

bool ConnectionRegistry::HasMore(int watch) const {
  MutexLock lock(mutex_);
  return CountsOf(watch).received != connections_.at(watch).record.received_bytes;
}

bool ConnectionRegistry::IsStranger(int watch) const {
  MutexLock lock(mutex_);
  return !connections_.at(watch).account.let_in();
}

void ConnectionRegistry::ShareAmongStrangers(uint64_t bytes) {
  MutexLock lock(mutex_);
  rations_.Share(std::max(bytes, allowances_.strangers_together()));
}

ConnectionRegistry::Division ConnectionRegistry::DivideAmongStrangers(ByteAccount::Clock::time_point now) {
  MutexLock lock(mutex_);
  StrangerRations::Division division = rations_.Divide(now);
  if (division.end.has_value()) End(*division.end, connections_.at(*division.end), StrangerReason::kMemoryShort);
  return {std::move(division.enter), division.end.has_value()};
}

uint64_t ConnectionRegistry::BytesBeyond(uint64_t spared, const Connection& connection) {
  if (connection.account.let_in() || connection.record.closed_for.has_value()) return 0;
  return connection.unaccounted - std::min(spared, connection.unaccounted);
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
    open.emplace_back(connection.record).received_bytes = CountsOf(watch).received;
  }
  return open;
}

void ConnectionRegistry::End(int watch, Connection& connection, StrangerReason reason) {
  if (connection.record.closed_for.has_value()) return;
  connection.record.closed_for = reason;
  shutdown(watch, SHUT_RDWR);
  // The system resets a connection that was shut down when more comes: the peer shall hear of it.
  rations_.End(watch, std::chrono::steady_clock::now());
  // Else gRPC would still read what waits.
  constexpr size_t kAll = size_t{1} << 30;
  recv(watch, nullptr, kAll, MSG_TRUNC | MSG_DONTWAIT);
}

ConnectionRegistry::Connection* ConnectionRegistry::Find(const std::string& peer) {
  const auto latest = watch_of_peer_.find(peer);
  return latest == watch_of_peer_.end() ? nullptr : &connections_.at(latest->second);
}

}  // namespace curvd
