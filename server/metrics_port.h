// The HTTP port that Prometheus scrapes.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace prometheus {
class Exposer;
}  // namespace prometheus

namespace curvd {

class ServerMetrics;

// Serves /metrics until destroyed.
class MetricsPort {
 public:
  // Listens on HOST:PORT. UNAVAILABLE, naming the address, if it cannot be bound. `metrics` must outlive the port.
  static absl::StatusOr<std::unique_ptr<MetricsPort>> Create(const std::string& listen, const ServerMetrics& metrics);
  ~MetricsPort();

  int port() const { return port_; }

 private:
  MetricsPort(std::string listen, std::unique_ptr<prometheus::Exposer> exposer, int port);

  const std::string listen_;
  std::unique_ptr<prometheus::Exposer> exposer_;
  const int port_;
};

}  // namespace curvd
