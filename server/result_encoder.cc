#include "server/result_encoder.h"

#include <bit>
#include <cstring>
#include <span>
#include <string>

namespace curvd {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire format is little-endian");

// Packs member `field` of each point into `bytes`, or empties it if the array was not asked for.
template <typename Field>
void Pack(std::span<const PointCurvature> points, bool wanted, Field PointCurvature::*field, std::string* bytes) {
  if (!wanted) {
    bytes->clear();
    return;
  }
  bytes->resize(points.size() * sizeof(Field));
  char* out = bytes->data();
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
  Pack(part, true, &PointCurvature::status, chunk->mutable_status());
  Pack(part, quantities.mean, &PointCurvature::mean, chunk->mutable_mean_curvature());
  Pack(part, quantities.gaussian, &PointCurvature::gaussian, chunk->mutable_gaussian_curvature());
  Pack(part, quantities.principal_curvatures, &PointCurvature::k1, chunk->mutable_k1());
  Pack(part, quantities.principal_curvatures, &PointCurvature::k2, chunk->mutable_k2());
  Pack(part, quantities.principal_directions, &PointCurvature::d1, chunk->mutable_d1());
  Pack(part, quantities.principal_directions, &PointCurvature::d2, chunk->mutable_d2());
  Pack(part, quantities.radius, &PointCurvature::radius, chunk->mutable_radius());
}

}  // namespace curvd
