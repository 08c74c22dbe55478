#include "server/observe/scrape_builder.h"

#include <utility>

namespace curvd {

void ScrapeBuilder::AddGauge(const char* name, const char* help, double value, Labels labels) {
  prometheus::ClientMetric& metric = Add(prometheus::MetricType::Gauge, name, help);
  metric.gauge.value = value;
  metric.label = std::move(labels);
}

void ScrapeBuilder::AddCounter(const char* name, const char* help, double value) {
  Add(prometheus::MetricType::Counter, name, help).counter.value = value;
}

prometheus::ClientMetric& ScrapeBuilder::Add(prometheus::MetricType type, const char* name, const char* help) {
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
