// Names for calls, so that a caller's error message leads to the server's log.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace curvd {

// Ids look like "5f3a9c21-17": eight random digits for each server, so that the ids of replicas and restarts differ,
// then the number of the call. Thread-safe.
class RequestIds {
 public:
  RequestIds();
  std::string Next();

 private:
  std::string prefix_;
  std::atomic<uint64_t> count_{0};
};

}  // namespace curvd
