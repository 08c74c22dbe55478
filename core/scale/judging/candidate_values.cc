#include "core/scale/judging/candidate_values.h"

#include <algorithm>
#include <limits>

namespace curvd {
namespace {

// Points whose values are copied together: a line of the cache holds so many.
constexpr size_t kCopiedTogether = 8;

}  // namespace

CandidateValues::CandidateValues(PilotPoints table, Quantity quantity)
    : samples_(table.size()), quantity_(quantity), none_(table.size(), std::numeric_limits<double>::quiet_NaN()) {
  values_.resize(PlaceCandidates(table) * PilotPoint::kParts * ComponentsOf(quantity) * samples_);
  for (size_t first = 0; first < samples_; first += kCopiedTogether) {
    Copy(table.subspan(first, std::min(kCopiedTogether, samples_ - first)), first);
  }
}

size_t CandidateValues::PlaceCandidates(PilotPoints table) {
  size_t count = 0;
  for (size_t method = 0; method < kMethodCount; ++method) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      const bool is_known = std::any_of(table.begin(), table.end(), [&](const PilotPoint& point) {
        const auto& parts = point.mean[method][rung];
        return std::any_of(parts.begin(), parts.end(), [](float mean) { return std::isfinite(mean); });
      });
      places_[method][rung] = is_known ? count++ : kUnknown;
    }
  }
  return count;
}

CandidateValues::Column CandidateValues::Of(const ScaleCandidate& candidate, PilotPoint::Part part) const {
  const size_t components = ComponentsOf(quantity_), place = places_[candidate.method][candidate.rung];
  const auto of_component = [&](size_t component) {
    if (place == kUnknown) return std::span(none_);
    const size_t column = (place * PilotPoint::kParts + part) * components + component;
    return std::span(values_).subspan(column * samples_, samples_);
  };
  return {of_component(0), components > 1 ? of_component(1) : std::span<const double>()};
}

void CandidateValues::Copy(PilotPoints points, size_t first) {
  double* out = values_.data() + first;
  const auto copy = [&](size_t method, size_t rung, size_t part, const auto& value_of) {
    for (size_t i = 0; i < points.size(); ++i) {
      const PilotPoint& point = points[i];
      const double mean = point.mean[method][rung][part], difference = point.difference[method][rung][part],
                   twist = point.twist[method][rung][part];
      // What overflows in one component is known of no quantity: all of them judge the same candidates.
      const bool is_known = std::isfinite(mean) && std::isfinite(difference) && std::isfinite(twist);
      out[i] = is_known ? value_of(mean, difference, twist) : std::numeric_limits<double>::quiet_NaN();
    }
    out += samples_;
  };
  for (size_t method = 0; method < kMethodCount; ++method) {
    for (size_t rung = 0; rung < kRungCount; ++rung) {
      if (places_[method][rung] == kUnknown) continue;
      for (size_t part = 0; part < PilotPoint::kParts; ++part) {
        switch (quantity_) {
          case Quantity::kMean:
            copy(method, rung, part, [](double mean, double, double) { return mean; });
            break;
          case Quantity::kTraceless:
            copy(method, rung, part, [](double, double difference, double) { return difference; });
            copy(method, rung, part, [](double, double, double twist) { return twist; });
            break;
          case Quantity::kGaussian:
            copy(method, rung, part, [](double mean, double difference, double twist) {
              return mean * mean - difference * difference - twist * twist;
            });
            break;
        }
      }
    }
  }
}

}  // namespace curvd
