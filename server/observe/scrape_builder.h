// Puts metrics together that are read when Prometheus asks, so that they are never stale.
#pragma once

#include <prometheus/metric_family.h>

#include <utility>
#include <vector>

namespace curvd {

// Collects the samples of one scrape into families of metrics. Not thread-safe.
class ScrapeBuilder {
 public:
  using Labels = std::vector<prometheus::ClientMetric::Label>;

  // Each adds a sample. REQUIRES: samples of one name follow each other.
  void AddGauge(const char* name, const char* help, double value, Labels labels = {});
  void AddCounter(const char* name, const char* help, double value);

  // The families with what was added, in that order; none are left.
  std::vector<prometheus::MetricFamily> TakeFamilies() { return std::move(families_); }

 private:
  prometheus::ClientMetric& Add(prometheus::MetricType type, const char* name, const char* help);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace curvd
