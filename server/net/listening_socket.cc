#include "server/net/listening_socket.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "server/net/listen_address.h"
#include "server/net/receive_valve.h"
#include "server/net/socket_option.h"

namespace curvd {
namespace {

constexpr int kBacklog = 4096;  // the system's own limit usually lies below

// A listening socket, or -1 with errno set.
int Listen(int family, const sockaddr* address, socklen_t length) {
  const int fd = socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  // A port whose last owner has just gone may be taken; one that has an owner may not.
  if (family != AF_UNIX) SetSocketOption(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  if (family == AF_INET6) SetSocketOption(fd, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  if (family != AF_UNIX) RememberBeginnings(fd);
  if (bind(fd, address, length) == 0 && listen(fd, kBacklog) == 0) return fd;
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

int PortOf(int fd) {
  sockaddr_storage address = {};
  socklen_t length = sizeof(address);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
  const auto port = address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                                  : reinterpret_cast<const sockaddr_in&>(address).sin_port;
  return ntohs(port);
}

void SetPort(sockaddr* address, int port) {
  if (address->sa_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6*>(address)->sin6_port = htons(static_cast<uint16_t>(port));
  } else {
    reinterpret_cast<sockaddr_in*>(address)->sin_port = htons(static_cast<uint16_t>(port));
  }
}

// Whether `path` is a socket that refuses connections, as its owner was killed.
bool IsAbandoned(const sockaddr_un& address) {
  struct stat info = {};
  if (stat(address.sun_path, &info) != 0 || !S_ISSOCK(info.st_mode)) return false;
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool refused =
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 && errno == ECONNREFUSED;
  close(fd);
  return refused;
}

}  // namespace

absl::StatusOr<ListeningSockets> ListeningSockets::Bind(const char* flag, const std::string& address) {
  ListeningSockets sockets;
  absl::string_view path = address;
  std::string failure;
  if (absl::ConsumePrefix(&path, "unix:")) {
    failure = sockets.BindUnix(std::string(path));
  } else {
    const HostPort split = SplitHostPort(address);
    failure = sockets.BindTcp(split.host, split.port);
  }
  if (failure.empty()) return sockets;
  return absl::UnavailableError(absl::StrCat("cannot listen on ", address, " (", flag, "): ", failure));
}

std::string ListeningSockets::BindUnix(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof(address.sun_path)) return "the path must have 1 to 107 bytes";
  path.copy(address.sun_path, path.size());
  if (IsAbandoned(address)) unlink(address.sun_path);
  const int fd = Listen(AF_UNIX, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  if (fd < 0) return std::strerror(errno);
  descriptors_.push_back(fd);
  unix_path_ = path;
  return "";
}

std::string ListeningSockets::BindTcp(const std::string& host, const std::string& port) {
  if (host.empty() || port.empty()) return "it must be HOST:PORT or unix:PATH";
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* list = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &list); error != 0) return gai_strerror(error);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, freeaddrinfo);
  int failure = 0;
  for (const addrinfo* info = list; info != nullptr; info = info->ai_next) {
    if (port_ != 0) SetPort(info->ai_addr, port_);
    const int fd = Listen(info->ai_family, info->ai_addr, info->ai_addrlen);
    if (fd >= 0) {
      descriptors_.push_back(fd);
      port_ = PortOf(fd);
    } else if (errno == EAFNOSUPPORT || errno == EADDRNOTAVAIL) {
      failure = errno;  // a name may have an address of a family that this machine has not
    } else {
      return std::strerror(errno);
    }
  }
  return descriptors_.empty() ? std::strerror(failure) : "";
}

ListeningSockets::ListeningSockets(ListeningSockets&& other) noexcept
    : descriptors_(std::exchange(other.descriptors_, {})),
      port_(other.port_),
      unix_path_(std::exchange(other.unix_path_, {})) {}

ListeningSockets::~ListeningSockets() {
  for (const int fd : descriptors_) close(fd);
  if (!unix_path_.empty()) unlink(unix_path_.c_str());
}

}  // namespace curvd
