// Finds the neighborhoods of single points of a group once more.

#if defined(CURVD_CORE_ESTIMATORS_FITS_REPEATED_SEARCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef CURVD_CORE_ESTIMATORS_FITS_REPEATED_SEARCH_INL_H_
#undef CURVD_CORE_ESTIMATORS_FITS_REPEATED_SEARCH_INL_H_
#else
#define CURVD_CORE_ESTIMATORS_FITS_REPEATED_SEARCH_INL_H_
#endif

#include <optional>

#include "core/estimators/fits/fit_scratch.h"
#include "core/search/group_search-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace curvd {
namespace HWY_NAMESPACE {

// For SolveJetSystems. `collect(search, i)` collects the neighbors of point i as s.neighbors.
template <typename Collect>
class RepeatedSearch {
 public:
  RepeatedSearch(const SpatialIndex& index, const SearchPlan& plan, int degree, JetScratch& s, Collect collect)
      : index_(index), plan_(plan), degree_(degree), s_(s), collect_(collect), began_(s.search.work) {}

  // Returns false, and collects nothing, once nobody wants the result, or the group has been ended before point i
  // because the factorizations of those before it took so much.
  HWY_NOINLINE bool operator()(size_t i) {
    if (s_.IsStopped()) return false;
    if (i > 0 && s_.IsLongSince(began_)) {
      s_.LeaveRest(i);
      return false;
    }
    if (!search_.has_value()) search_.emplace(index_, plan_, s_.points.box, s_.search);
    collect_(*search_, i);
    // A step for every four multiplications and additions of the factorization, and of those of lower degrees that may
    // follow.
    const auto size = static_cast<size_t>(JetSize(degree_));
    s_.search.work += s_.neighbors.count * size * size * 5 / 6;
    return true;
  }

 private:
  const SpatialIndex& index_;
  const SearchPlan& plan_;
  const int degree_;
  JetScratch& s_;
  const Collect collect_;
  const uint64_t began_;
  std::optional<GroupSearch> search_;
};

}  // namespace HWY_NAMESPACE
}  // namespace curvd
HWY_AFTER_NAMESPACE();

#endif  // CURVD_CORE_ESTIMATORS_FITS_REPEATED_SEARCH_INL_H_
