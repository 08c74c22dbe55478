#include "server/net/connection_acceptor.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/net/keepalive.h"
#include "server/net/listen_address.h"

namespace curvd {
namespace {

// Sweeping ten thousand connections takes some milliseconds: under attack, at most so often.
constexpr auto kSweepInterval = std::chrono::milliseconds(100);
// How long to wait for descriptors when the system has none left.
constexpr int kNoDescriptorPauseMs = 100;

// The peer as gRPC writes it.
std::string PeerOf(const sockaddr_storage& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &v4.sin_addr, text, sizeof(text));
    return absl::StrCat("ipv4:", text, ":", ntohs(v4.sin_port));
  }
  if (address.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
    inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof(text));
    return absl::StrCat("ipv6:[", text, "]:", ntohs(v6.sin6_port));
  }
  return "unix:";
}

void ConfigureSocket(int fd) {
  const int no_delay = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &no_delay, sizeof(no_delay));
  // gRPC's keepalive cannot ask behind results that the peer does not take, so the system gives up then. A caller that
  // reads slowly is safe: its gRPC empties the socket, and HTTP/2 holds the results back.
  const unsigned patience = kKeepaliveTimeMs + kKeepaliveTimeoutMs;
  setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience, sizeof(patience));
}

}  // namespace

ConnectionAcceptor::ConnectionAcceptor(ListeningSockets sockets, const ConnectionLimits& limits, OnRefused on_refused)
    : sockets_(std::move(sockets)),
      limits_(limits),
      on_refused_(std::move(on_refused)),
      wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

ConnectionAcceptor::~ConnectionAcceptor() {
  Stop();
  close(wake_fd_);
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
}

size_t ConnectionAcceptor::OpenCount() {
  MutexLock lock(mutex_);
  table_.Sweep();
  return table_.size();
}

std::string ConnectionAcceptor::PeerBeingClosed() {
  MutexLock lock(mutex_);
  return table_.PeerBeingClosed();
}

void ConnectionAcceptor::Run() {
  std::vector<pollfd> waiting = {{wake_fd_, POLLIN, 0}};
  for (const int fd : sockets_.descriptors()) waiting.push_back({fd, POLLIN, 0});
  while (!stopping_) {
    if (poll(waiting.data(), waiting.size(), -1) < 0) continue;  // a signal
    for (size_t i = 1; i < waiting.size(); ++i) {
      if (waiting[i].revents != 0) AcceptAll(waiting[i].fd);
    }
  }
}

void ConnectionAcceptor::AcceptAll(int listener) {
  while (!stopping_) {
    sockaddr_storage address = {};
    socklen_t length = sizeof(address);
    const int fd = accept4(listener, reinterpret_cast<sockaddr*>(&address), &length, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) {
      if (errno == EINTR || errno == ECONNABORTED) continue;
      if (errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM) return;
      on_refused_(StrangerReason::kNoDescriptor, "");
      pollfd wake = {wake_fd_, POLLIN, 0};
      poll(&wake, 1, kNoDescriptorPauseMs);
      return;
    }
    const std::string peer = PeerOf(address);
    StrangerReason reason;
    if (!MayStay(fd, peer, reason)) {
      close(fd);
      on_refused_(reason, peer);
      continue;
    }
    ConfigureSocket(fd);
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
    connection.listener_fd = listener;
    connection.fd = fd;
    target_->HandleNewConnection(&connection);
  }
}

bool ConnectionAcceptor::MayStay(int fd, const std::string& peer, StrangerReason& reason) {
  MutexLock lock(mutex_);
  const std::string address = PeerAddress(peer);
  const bool is_full = table_.size() >= limits_.max_connections;
  if (is_full || table_.CountOf(address) >= limits_.max_per_peer) {
    const auto now = std::chrono::steady_clock::now();
    if (now - swept_ >= kSweepInterval) {
      table_.Sweep();
      swept_ = now;
    }
  }
  if (table_.size() >= limits_.max_connections) {
    reason = StrangerReason::kConnectionLimit;
    return false;
  }
  if (table_.CountOf(address) >= limits_.max_per_peer) {
    reason = StrangerReason::kPeerConnectionLimit;
    return false;
  }
  table_.Add(fd, peer);
  return true;
}

}  // namespace curvd
