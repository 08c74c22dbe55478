#include "server/result_encoder.h"

#include <bit>
#include <span>
#include <string>

#include "core/field_arrays.h"

namespace curvd {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire format is little-endian");

// Room for `size` bytes if the array was asked for, else an empty array.
char* MakeRoom(bool wanted, size_t size, std::string* bytes) {
  bytes->resize(wanted ? size : 0);
  return wanted ? bytes->data() : nullptr;
}

}  // namespace

void EncodeResults(const PageArray<PointCurvature>& points, size_t first, size_t count, const QuantitySet& quantities,
                   curvature::v1::ResultChunk* chunk) {
  const size_t scalars = count * sizeof(float), vectors = 3 * scalars;
  chunk->set_first_index(first);
  chunk->set_point_count(static_cast<uint32_t>(count));
  SplitField(points.span().subspan(first, count),
             {.mean = MakeRoom(quantities.mean, scalars, chunk->mutable_mean_curvature()),
              .gaussian = MakeRoom(quantities.gaussian, scalars, chunk->mutable_gaussian_curvature()),
              .k1 = MakeRoom(quantities.principal_curvatures, scalars, chunk->mutable_k1()),
              .k2 = MakeRoom(quantities.principal_curvatures, scalars, chunk->mutable_k2()),
              .d1 = MakeRoom(quantities.principal_directions, vectors, chunk->mutable_d1()),
              .d2 = MakeRoom(quantities.principal_directions, vectors, chunk->mutable_d2()),
              .radius = MakeRoom(quantities.radius, scalars, chunk->mutable_radius()),
              .status = MakeRoom(true, count, chunk->mutable_status())});
}

}  // namespace curvd
