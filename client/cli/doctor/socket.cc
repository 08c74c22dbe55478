#include "client/cli/doctor/socket.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace curv {
namespace {

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
