#include "server/metrics_port.h"

#include <prometheus/exposer.h>

#include <exception>
#include <utility>
#include <vector>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "server/server_metrics.h"

namespace curvd {

absl::StatusOr<std::unique_ptr<MetricsPort>> MetricsPort::Create(const std::string& listen,
                                                                 const ServerMetrics& metrics) {
  // A scraper that connects and says nothing must not hold a thread for ever.
  const std::vector<std::string> settings = {"listening_ports",    listen, "num_threads", "4",
                                             "request_timeout_ms", "5000"};
  try {
    auto exposer = std::make_unique<prometheus::Exposer>(settings);
    for (const auto& collectable : metrics.collectables()) exposer->RegisterCollectable(collectable);
    const std::vector<int> ports = exposer->GetListeningPorts();
    return absl::WrapUnique(new MetricsPort(std::move(exposer), ports.empty() ? 0 : ports.front()));
  } catch (const std::exception& error) {
    return absl::UnavailableError(absl::StrCat("cannot listen for metrics on ", listen,
                                               ": in use, not permitted, or no address of this machine"));
  }
}

MetricsPort::MetricsPort(std::unique_ptr<prometheus::Exposer> exposer, int port)
    : exposer_(std::move(exposer)), port_(port) {}

MetricsPort::~MetricsPort() = default;

}  // namespace curvd
