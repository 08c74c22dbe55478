#include "client/cli/doctor/socket.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "absl/strings/str_cat.h"

namespace curv {
namespace {

std::string TextOf(const addrinfo& info) {
  char host[NI_MAXHOST];
  char port[NI_MAXSERV];
  if (getnameinfo(info.ai_addr, info.ai_addrlen, host, sizeof(host), port, sizeof(port),
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "an address of unknown kind";
  }
  return info.ai_family == AF_INET6 ? absl::StrCat("[", host, "]:", port) : absl::StrCat(host, ":", port);
}

// 0, or why no connection came about.
int AwaitConnected(int descriptor, absl::Duration timeout) {
  pollfd waiting = {descriptor, POLLOUT, 0};
  const int ready = poll(&waiting, 1, static_cast<int>(absl::ToInt64Milliseconds(timeout)));
  if (ready < 0) return errno;
  if (ready == 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

absl::Status StatusOf(int error) {
  if (error == ECONNREFUSED) return absl::UnavailableError("refused");
  if (error == ETIMEDOUT) return absl::DeadlineExceededError("no answer");
  return absl::UnknownError(std::strerror(error));
}

}  // namespace

absl::StatusOr<std::vector<Address>> LookUp(const std::string& host, const std::string& port) {
  addrinfo hints = {};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    return absl::NotFoundError(gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::vector<Address> addresses;
  for (const addrinfo* info = found; info != nullptr; info = info->ai_next) {
    Address address{.size = info->ai_addrlen, .text = TextOf(*info)};
    std::memcpy(&address.bytes, info->ai_addr, info->ai_addrlen);
    const bool is_known = std::any_of(addresses.begin(), addresses.end(),
                                      [&](const Address& other) { return other.text == address.text; });
    if (!is_known) addresses.push_back(std::move(address));
  }
  return addresses;
}

absl::StatusOr<Socket> Socket::Connect(const Address& address, absl::Duration timeout) {
  Socket made(socket(address.bytes.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (made.descriptor_ < 0) return StatusOf(errno);
  int error = 0;
  if (connect(made.descriptor_, reinterpret_cast<const sockaddr*>(&address.bytes), address.size) != 0) {
    error = errno == EINPROGRESS ? AwaitConnected(made.descriptor_, timeout) : errno;
  }
  if (error != 0) return StatusOf(error);
  // From here on calls wait.
  fcntl(made.descriptor_, F_SETFL, fcntl(made.descriptor_, F_GETFL) & ~O_NONBLOCK);
  const timeval limit = absl::ToTimeval(timeout);
  setsockopt(made.descriptor_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(made.descriptor_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
  return made;
}

Socket::~Socket() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool Socket::Send(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

std::string Socket::Receive(size_t least) const {
  std::string received;
  char buffer[4096];
  while (received.size() < least) {
    const ssize_t size = recv(descriptor_, buffer, sizeof(buffer), 0);
    if (size <= 0) break;
    received.append(buffer, static_cast<size_t>(size));
  }
  return received;
}

}  // namespace curv
