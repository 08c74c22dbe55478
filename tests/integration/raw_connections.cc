#include "tests/integration/raw_connections.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace curvd {
namespace {

sockaddr_in Address(const std::string& host, int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  EXPECT_EQ(inet_pton(AF_INET, host.c_str(), &address.sin_addr), 1);
  return address;
}

bool IsOpen(int fd) {
  char byte = 0;
  const ssize_t count = recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return count > 0 || (count < 0 && errno == EAGAIN);
}

}  // namespace

RawConnections::RawConnections(const std::string& source, int port, size_t count) {
  const sockaddr_in from = Address(source, 0), to = Address("127.0.0.1", port);
  for (size_t i = 0; i < count; ++i) {
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_GE(fd, 0);
    descriptors_.push_back(fd);
    EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&from), sizeof(from)), 0);
    EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);
  }
}

RawConnections::~RawConnections() {
  for (const int fd : descriptors_) close(fd);
}

size_t RawConnections::CountOpen() const {
  return static_cast<size_t>(std::count_if(descriptors_.begin(), descriptors_.end(), IsOpen));
}

void RawConnections::Send(const std::string& bytes) const {
  EXPECT_EQ(send(descriptors_.front(), bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
}

std::string RawConnections::ReadFor(std::chrono::milliseconds time) const {
  const auto end = std::chrono::steady_clock::now() + time;
  std::string received;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd readable = {descriptors_.front(), POLLIN, 0};
    if (left.count() <= 0 || poll(&readable, 1, static_cast<int>(left.count())) <= 0) return received;
    char bytes[1024];
    const ssize_t count = recv(descriptors_.front(), bytes, sizeof(bytes), 0);
    if (count <= 0) return received;
    received.append(bytes, static_cast<size_t>(count));
  }
}

void RawConnections::SendAndWaitForClose(const std::string& bytes) const {
  Send(bytes);
  char answer[1024];
  while (recv(descriptors_.front(), answer, sizeof(answer), 0) > 0) {
  }
}

}  // namespace curvd
