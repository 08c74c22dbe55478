// A TCP connection over loopback, whose both ends are in this process.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/net/receive_valve.h"

namespace curvd {

// What is still open is closed on destruction.
class TcpPair {
 public:
  TcpPair() {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    auto* any = reinterpret_cast<sockaddr*>(&address);
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    RememberBeginnings(listener);
    EXPECT_EQ(bind(listener, any, length), 0);
    EXPECT_EQ(listen(listener, 1), 0);
    EXPECT_EQ(getsockname(listener, any, &length), 0);
    client_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(connect(client_, any, length), 0);
    server_ = accept(listener, nullptr, nullptr);
    close(listener);
  }
  ~TcpPair() {
    if (client_ >= 0) close(client_);
    if (server_ >= 0) close(server_);
  }
  TcpPair(const TcpPair&) = delete;
  TcpPair& operator=(const TcpPair&) = delete;

  int client() const { return client_; }
  int server() const { return server_; }
  // As gRPC does.
  void ShutDownAndCloseServer() {
    shutdown(server_, SHUT_RDWR);
    close(server_);
    server_ = -1;
  }

 private:
  int client_;
  int server_;
};

}  // namespace curvd
