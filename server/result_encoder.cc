#include "server/result_encoder.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <string>

namespace curvd {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire format is little-endian");

// Points that are packed, array by array, while they are in the first cache.
constexpr size_t kBatchPoints = 256;

// Makes room for `count` fields, or none if the array was not asked for.
template <typename Field>
void Resize(bool wanted, size_t count, Field PointCurvature::* /*field*/, std::string* bytes) {
  bytes->resize(wanted ? count * sizeof(Field) : 0);
}

// Packs member `field` of each point from place `first` on, unless the array was not asked for.
template <typename Field>
void Pack(std::span<const PointCurvature> points, size_t first, Field PointCurvature::*field, std::string* bytes) {
  if (bytes->empty()) return;
  char* out = bytes->data() + first * sizeof(Field);
  for (const PointCurvature& point : points) {
    std::memcpy(out, &(point.*field), sizeof(Field));
    out += sizeof(Field);
  }
}

}  // namespace

void EncodeResults(const PageArray<PointCurvature>& points, size_t first, size_t count, const QuantitySet& quantities,
                   curvature::v1::ResultChunk* chunk) {
  const std::span<const PointCurvature> part = points.span().subspan(first, count);
  chunk->set_first_index(first);
  chunk->set_point_count(static_cast<uint32_t>(count));
  const auto for_each_array = [&](const auto& act) {
    act(true, &PointCurvature::status, chunk->mutable_status());
    act(quantities.mean, &PointCurvature::mean, chunk->mutable_mean_curvature());
    act(quantities.gaussian, &PointCurvature::gaussian, chunk->mutable_gaussian_curvature());
    act(quantities.principal_curvatures, &PointCurvature::k1, chunk->mutable_k1());
    act(quantities.principal_curvatures, &PointCurvature::k2, chunk->mutable_k2());
    act(quantities.principal_directions, &PointCurvature::d1, chunk->mutable_d1());
    act(quantities.principal_directions, &PointCurvature::d2, chunk->mutable_d2());
    act(quantities.radius, &PointCurvature::radius, chunk->mutable_radius());
  };
  for_each_array([&](bool wanted, auto field, std::string* bytes) { Resize(wanted, count, field, bytes); });
  for (size_t done = 0; done < count; done += kBatchPoints) {
    const auto batch = part.subspan(done, std::min(kBatchPoints, count - done));
    for_each_array([&](bool, auto field, std::string* bytes) { Pack(batch, done, field, bytes); });
  }
}

}  // namespace curvd
