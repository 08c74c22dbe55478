// TCP connections of somebody who means no good, or nothing at all.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace curvd {

// Connections from one loopback address to a port of this machine, that say nothing. Closed on destruction.
class RawConnections {
 public:
  // Connects `count` times from `source`, such as "127.0.0.2". Those that the server closes count as well.
  RawConnections(const std::string& source, int port, size_t count);
  ~RawConnections();
  RawConnections(const RawConnections&) = delete;
  RawConnections& operator=(const RawConnections&) = delete;

  // How many the server has not closed.
  size_t CountOpen() const;
  // Sends `bytes` on the first.
  void Send(const std::string& bytes) const;
  // What the server sends on the first, until it closes it or `time` is over.
  std::string ReadFor(std::chrono::milliseconds time) const;
  // Sends `bytes` on the first, and waits until the server closes it.
  void SendAndWaitForClose(const std::string& bytes) const;

 private:
  std::vector<int> descriptors_;
};

}  // namespace curvd
