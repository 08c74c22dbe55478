#include "server/observe/scraped_families.h"

#include <utility>

namespace curvd {

void ScrapedFamilies::Gauge(const char* name, const char* help, double value, Labels labels) {
  prometheus::ClientMetric& metric = Add(prometheus::MetricType::Gauge, name, help);
  metric.gauge.value = value;
  metric.label = std::move(labels);
}

void ScrapedFamilies::Counter(const char* name, const char* help, double value) {
  Add(prometheus::MetricType::Counter, name, help).counter.value = value;
}

prometheus::ClientMetric& ScrapedFamilies::Add(prometheus::MetricType type, const char* name, const char* help) {
  if (families_.empty() || families_.back().name != name) {
    prometheus::MetricFamily family;
    family.name = name;
    family.help = help;
    family.type = type;
    families_.push_back(std::move(family));
  }
  return families_.back().metric.emplace_back();
}

}  // namespace curvd
