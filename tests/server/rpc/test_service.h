// What all calls of a server share, for tests without a server.
#pragma once

#include <prometheus/collectable.h>
#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "server/service_context.h"

namespace curvd {

// One worker, no log; small limits where a test wants to reach them.
inline ServerOptions TestServiceOptions() {
  ServerOptions options;
  options.threads = 1;
  options.log = false;
  options.memory_limit_bytes = 256 << 20;
  options.stall_timeout = absl::Seconds(10);
  return options;
}

// The value of the series that is written as `series` in a scrape; -1 if there is none.
inline double MetricOf(const ServerMetrics& metrics, const std::string& series) {
  std::string text = "\n";
  for (const auto& collectable : metrics.collectables()) {
    text += prometheus::TextSerializer().Serialize(collectable->Collect());
  }
  const size_t found = text.find("\n" + series + " ");
  return found == std::string::npos ? -1.0 : std::atof(text.c_str() + found + series.size() + 2);
}

// A list of one token, which is "secret", of `name`.
inline std::vector<AccessEntry> OneToken(const std::string& name) { return {{name, HashToken("secret"), 0, 0}}; }

inline RpcArrival ArrivalFrom(const std::string& peer) {
  RpcArrival arrival;
  arrival.presented.peer = peer;
  return arrival;
}

}  // namespace curvd
