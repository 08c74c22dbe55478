// Reads what the system knows of this process, under the names that Prometheus' own client libraries use.
#pragma once

#include <prometheus/collectable.h>

#include <vector>

namespace curvd {

// Resident and virtual bytes, CPU seconds, threads, descriptors and their limit, start time. A value that /proc does
// not tell is left out. Thread-safe.
class ProcessMetrics : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override;
};

}  // namespace curvd
