// Metrics that are read when Prometheus asks, so that they are never stale.
#pragma once

#include <prometheus/metric_family.h>

#include <utility>
#include <vector>

namespace curvd {

// Collects the samples of one scrape. Not thread-safe.
class ScrapedFamilies {
 public:
  using Labels = std::vector<prometheus::ClientMetric::Label>;

  // Samples of one name must follow each other.
  void Gauge(const char* name, const char* help, double value, Labels labels = {});
  void Counter(const char* name, const char* help, double value);

  std::vector<prometheus::MetricFamily> Release() { return std::move(families_); }

 private:
  prometheus::ClientMetric& Add(prometheus::MetricType type, const char* name, const char* help);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace curvd
