#include "server/net/connection_acceptor.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/keepalive.h"
#include "server/net/listen_address.h"
#include "server/net/socket_option.h"

namespace curvd {
namespace {

// How many connections are taken before those that ended have their turn.
constexpr int kAcceptedInTurn = 64;
constexpr int kEventsAtOnce = 64;
// What is polled at a connection that is quiet. gRPC may have read what came before epoll is asked; EPOLLIN alone would
// not tell of it then. A connection can be written to nearly always, so that it is told of whenever something came, and
// once when polling begins.
constexpr uint32_t kBytesCome = EPOLLIN | EPOLLOUT | EPOLLET;
// How long to wait for descriptors when the system has none left.
constexpr int kNoDescriptorPauseMs = 100;

// The peer as gRPC 1.51 writes it in ServerContext::peer().
std::string PeerOf(const sockaddr_storage& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &v4.sin_addr, text, sizeof(text));
    return absl::StrCat("ipv4:", text, ":", ntohs(v4.sin_port));
  }
  if (address.ss_family != AF_INET6) return "unix:";
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  if (IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) {
    inet_ntop(AF_INET, &v6.sin6_addr.s6_addr[12], text, sizeof(text));
    return absl::StrCat("ipv4:", text, ":", ntohs(v6.sin6_port));
  }
  inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof(text));
  const std::string zone = v6.sin6_scope_id == 0 ? "" : absl::StrCat("%25", v6.sin6_scope_id);
  return absl::StrCat("ipv6:%5B", text, zone, "%5D:", ntohs(v6.sin6_port));
}

void ConfigureSocket(int fd) {
  SetSocketOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  // gRPC's keepalive cannot ask behind results that the peer does not take, so the system gives up then. A caller that
  // reads slowly is safe: its gRPC empties the socket, and HTTP/2 holds the results back.
  constexpr int patience_ms = kKeepaliveTimeMs + kKeepaliveTimeoutMs;
  SetSocketOption(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, patience_ms);
  // A connection without a call has nothing on its way, and gRPC does not ask whether its peer is there. The system
  // does, and the peer's system answers, which costs its process nothing.
  SetSocketOption(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  SetSocketOption(fd, IPPROTO_TCP, TCP_KEEPIDLE, kKeepaliveTimeMs / 1000);
  SetSocketOption(fd, IPPROTO_TCP, TCP_KEEPINTVL, kKeepaliveTimeoutMs / 1000);
}

// Has `epoll_fd` tell of `events` at `fd`, and of its end in any case.
void Poll(int epoll_fd, int operation, int fd, uint32_t events) {
  epoll_event event = {};
  event.events = events;
  event.data.fd = fd;
  epoll_ctl(epoll_fd, operation, fd, &event);
}

}  // namespace

ConnectionAcceptor::ConnectionAcceptor(ListeningSockets sockets, const ConnectionLimits& limits,
                                       ConnectionRegistry& connections, MemoryPressure& memory, Events events)
    : sockets_(std::move(sockets)),
      limits_(limits),
      connections_(connections),
      guard_(connections, memory),
      events_(std::move(events)),
      epoll_fd_(epoll_create1(EPOLL_CLOEXEC)),
      wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  Poll(epoll_fd_, EPOLL_CTL_ADD, wake_fd_, EPOLLIN);
  for (const int fd : sockets_.descriptors()) Poll(epoll_fd_, EPOLL_CTL_ADD, fd, EPOLLIN);
}

ConnectionAcceptor::~ConnectionAcceptor() {
  Stop();
  close(wake_fd_);
  close(epoll_fd_);
}

void ConnectionAcceptor::Start(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> target) {
  target_ = std::move(target);
  thread_ = std::thread([this] { Run(); });
}

void ConnectionAcceptor::Stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  eventfd_write(wake_fd_, 1);
  thread_.join();
  for (const auto& [watch, waiting] : at_door_) close(waiting.fd);
  at_door_.clear();
  connections_.Clear();
}

void ConnectionAcceptor::Run() {
  std::array<epoll_event, kEventsAtOnce> events;
  while (!stopping_) {
    const int count =
        epoll_wait(epoll_fd_, events.data(), kEventsAtOnce, guard_.WaitMs(std::chrono::steady_clock::now()));
    // Connections that ended make room for those that wait.
    for (int i = 0; i < count; ++i) {
      const int fd = events[i].data.fd;
      if (fd == wake_fd_ || IsListener(fd)) continue;
      if ((events[i].events & (EPOLLHUP | EPOLLERR)) != 0) {
        RemoveEnded(fd);
      } else if (connections_.HasMore(fd)) {
        // The guard looks again and again now, without being woken by each segment.
        Poll(epoll_fd_, EPOLL_CTL_MOD, fd, 0);
        guard_.Wake(fd);
      }
    }
    for (int i = 0; i < count; ++i) {
      if (IsListener(events[i].data.fd)) AcceptSome(events[i].data.fd);
    }
    Guard();
  }
}

bool ConnectionAcceptor::IsListener(int fd) const {
  const std::vector<int>& listeners = sockets_.descriptors();
  return std::find(listeners.begin(), listeners.end(), fd) != listeners.end();
}

void ConnectionAcceptor::RemoveEnded(int watch) {
  // gRPC may still have the socket open: closing the watch alone would leave it polled.
  epoll_ctl(epoll_fd_, EPOLL_CTL_DEL, watch, nullptr);
  guard_.Forget(watch);
  if (const auto waiting = at_door_.extract(watch)) close(waiting.mapped().fd);
  const ConnectionRecord connection = connections_.Remove(watch);
  if (events_.ended) events_.ended(connection, std::chrono::steady_clock::now() - connection.accepted);
}

void ConnectionAcceptor::Guard() {
  const auto now = std::chrono::steady_clock::now();
  if (guard_.WaitMs(now) != 0) return;
  const ConnectionGuard::Sights sights = guard_.Turn(now, ResidentBytes());
  for (const int watch : sights.quiet) Poll(epoll_fd_, EPOLL_CTL_MOD, watch, kBytesCome);
  for (const int watch : sights.enter) {
    if (const auto waited = at_door_.extract(watch)) HandOver(waited.mapped().listener, waited.mapped().fd);
  }
}

void ConnectionAcceptor::AcceptSome(int listener) {
  guard_.ShareAmongStrangers(ResidentBytes());
  for (int taken = 0; taken < kAcceptedInTurn && !stopping_; ++taken) {
    sockaddr_storage address = {};
    socklen_t length = sizeof(address);
    const int fd = accept4(listener, reinterpret_cast<sockaddr*>(&address), &length, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd >= 0) {
      Receive(listener, fd, PeerOf(address));
      continue;
    }
    if (errno == EINTR || errno == ECONNABORTED) continue;
    if (errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM) return;
    Refuse(StrangerReason::kNoDescriptor, "");
    pollfd wake = {wake_fd_, POLLIN, 0};
    poll(&wake, 1, kNoDescriptorPauseMs);
    return;
  }
}

void ConnectionAcceptor::Receive(int listener, int fd, const std::string& peer) {
  StrangerReason reason = StrangerReason::kNoDescriptor;
  const std::optional<ConnectionRegistry::Added> added =
      MayStay(peer, reason) ? connections_.Add(fd, peer) : std::nullopt;
  if (!added.has_value()) {
    close(fd);
    return Refuse(reason, peer);
  }
  ConfigureSocket(fd);
  Poll(epoll_fd_, EPOLL_CTL_ADD, added->watch, kBytesCome);
  if (added->may_enter) return HandOver(listener, fd);
  at_door_.emplace(added->watch, AtDoor{listener, fd});
}

void ConnectionAcceptor::HandOver(int listener, int fd) {
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = listener;
  connection.fd = fd;
  target_->HandleNewConnection(&connection);
}

bool ConnectionAcceptor::MayStay(const std::string& peer, StrangerReason& reason) const {
  if (!guard_.MayTake()) {
    reason = StrangerReason::kMemoryShort;
    return false;
  }
  if (connections_.size() >= limits_.max_connections) {
    reason = StrangerReason::kConnectionLimit;
    return false;
  }
  if (connections_.CountFrom(PeerAddress(peer)) >= limits_.max_per_peer) {
    reason = StrangerReason::kPeerConnectionLimit;
    return false;
  }
  return true;
}

void ConnectionAcceptor::Refuse(StrangerReason reason, const std::string& peer) const {
  if (events_.refused) events_.refused(reason, peer);
}

}  // namespace curvd
