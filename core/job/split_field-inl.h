// Transposes points of a field, four at a time.

#if defined(CURVD_CORE_JOB_SPLIT_FIELD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#undef CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#else
#define CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
#endif

#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "core/job/field_arrays.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Calls visit.operator()<i>() for each column i, in order.
template <typename Visit>
HWY_INLINE void ForEachColumn(const Visit& visit) {
  [&visit]<size_t... kIndex>(std::index_sequence<kIndex...>) HWY_ATTR { (visit.template operator()<kIndex>(), ...); }
  (std::make_index_sequence<kColumnCount>());
}

template <size_t kIndex>
HWY_INLINE void CopyColumn(const PointCurvature& point, size_t i, char* out) {
  constexpr size_t kBytes = kColumns[kIndex].bytes();
  std::memcpy(out + i * kBytes, reinterpret_cast<const char*>(&point) + kColumns[kIndex].offset, kBytes);
}

HWY_INLINE void SplitPoint(const PointCurvature& point, size_t i, const ColumnPlaces& places) {
  ForEachColumn([&]<size_t kIndex>() HWY_ATTR {
    if (places[kIndex] != nullptr) CopyColumn<kIndex>(point, i, places[kIndex]);
  });
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE size_t SplitByFours(std::span<const PointCurvature> /*points*/, const ColumnPlaces& /*places*/) { return 0; }

#else

using FourFloats = hn::FixedTag<float, 4>;
using FourFloatsVec = hn::Vec<FourFloats>;

// A point as vectors of four words, the last of which may reach into the next point.
inline constexpr size_t kParts = (sizeof(PointCurvature) + 15) / 16;
static_assert(sizeof(PointCurvature) % sizeof(float) == 0);

// Four points.
struct FourPoints {
  FourFloatsVec parts[kParts][4];
};

// Stores a column of one float: a column of the 4 x 4 matrix that one part of the four points makes.
template <size_t kIndex>
HWY_INLINE void StoreScalars(const FourPoints& points, size_t i, char* out) {
  const FourFloats d;
  constexpr size_t kWord = kColumns[kIndex].offset / sizeof(float);
  const auto& rows = points.parts[kWord / 4];
  FourFloatsVec rows01, rows23;
  if constexpr (kWord % 4 < 2) {
    rows01 = hn::InterleaveLower(d, rows[0], rows[1]);
    rows23 = hn::InterleaveLower(d, rows[2], rows[3]);
  } else {
    rows01 = hn::InterleaveUpper(d, rows[0], rows[1]);
    rows23 = hn::InterleaveUpper(d, rows[2], rows[3]);
  }
  float* place = reinterpret_cast<float*>(out + i * sizeof(float));
  if constexpr (kWord % 2 == 0) {
    hn::StoreU(hn::ConcatLowerLower(d, rows23, rows01), d, place);
  } else {
    hn::StoreU(hn::ConcatUpperUpper(d, rows23, rows01), d, place);
  }
}

// Stores a column of three floats. Writes a float too many behind the last point.
template <size_t kIndex>
HWY_INLINE void StoreTriples(const FourPoints& points, size_t i, char* out) {
  const FourFloats d;
  constexpr size_t kWord = kColumns[kIndex].offset / sizeof(float), kPart = kWord / 4, kSkipped = kWord % 4;
  // In this order: the float too many lies where the next point's triple goes.
  for (size_t point = 0; point < 4; ++point) {
    float* place = reinterpret_cast<float*>(out + 3 * sizeof(float) * (i + point));
    if constexpr (kSkipped == 0) {
      hn::StoreU(points.parts[kPart][point], d, place);
    } else {
      constexpr size_t kNext = kPart + 1 < kParts ? kPart + 1 : kPart;
      hn::StoreU(hn::CombineShiftRightBytes<kSkipped * sizeof(float)>(d, points.parts[kNext][point],
                                                                      points.parts[kPart][point]),
                 d, place);
    }
  }
}

// Points [i, i + 4). REQUIRES: there is a point behind them.
HWY_INLINE void SplitFour(const PointCurvature* points, size_t i, const ColumnPlaces& places) {
  const FourFloats d;
  FourPoints four;
  for (size_t part = 0; part < kParts; ++part) {
    for (size_t point = 0; point < 4; ++point) {
      four.parts[part][point] = hn::LoadU(d, reinterpret_cast<const float*>(&points[i + point]) + 4 * part);
    }
  }
  ForEachColumn([&]<size_t kIndex>() HWY_ATTR {
    char* out = places[kIndex];
    if (out == nullptr) return;
    constexpr Column kColumn = kColumns[kIndex];
    constexpr bool kFloats = kColumn.type == ColumnType::kFloat32 && kColumn.offset % sizeof(float) == 0;
    if constexpr (kFloats && kColumn.width == 1) {
      StoreScalars<kIndex>(four, i, out);
    } else if constexpr (kFloats && kColumn.width == 3) {
      StoreTriples<kIndex>(four, i, out);
    } else {
      for (size_t point = i; point < i + 4; ++point) CopyColumn<kIndex>(points[point], point, out);
    }
  });
}

// Returns how many points it split; never all of them, so that what it writes too many is written again.
HWY_INLINE size_t SplitByFours(std::span<const PointCurvature> points, const ColumnPlaces& places) {
  size_t i = 0;
  for (; i + 4 < points.size(); i += 4) SplitFour(points.data(), i, places);
  return i;
}

#endif

inline void SplitFieldKernel(std::span<const PointCurvature> points, const ColumnPlaces& places) {
  for (size_t i = SplitByFours(points, places); i < points.size(); ++i) SplitPoint(points[i], i, places);
}

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_JOB_SPLIT_FIELD_INL_H_
