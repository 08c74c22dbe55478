// Serves the HTTP port that Prometheus scrapes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace prometheus {
class Collectable;
class Exposer;
}  // namespace prometheus

namespace curvd {

// Serves GET and HEAD of /metrics until destroyed; answers other methods with 405. Those who do not finish their
// request delay others by a second for each 32 of them.
class MetricsPort {
 public:
  // Listens on HOST:PORT and shows all of `collectables`. UNAVAILABLE, naming the address, if it cannot be bound.
  static absl::StatusOr<std::unique_ptr<MetricsPort>> Create(
      const std::string& listen, std::vector<std::shared_ptr<prometheus::Collectable>> collectables);
  ~MetricsPort();

  int port() const { return port_; }

 private:
  MetricsPort(std::string listen, std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
              std::unique_ptr<prometheus::Exposer> exposer, int port);

  const std::string listen_;
  const std::vector<std::shared_ptr<prometheus::Collectable>> collectables_;  // the exposer does not keep them
  std::unique_ptr<prometheus::Exposer> exposer_;
  const int port_;
};

}  // namespace curvd
