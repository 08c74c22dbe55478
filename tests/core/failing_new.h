// Lets an allocation of the process fail, and counts what is allocated. For tests in executables of their own, which
// link failing_new.cc: it replaces operator new.
#pragma once

#include <cstddef>

namespace curvd::testing {

// While one of these lives, allocations by operator new are counted on all threads, and one of them, or all from that
// one on, find no memory: they throw std::bad_alloc, or return null in the form that throws nothing. Not more than one
// at a time.
class FailingNew {
 public:
  enum class Failing { kOne, kAllFromThere };
  // `first`: how many allocations succeed before.
  FailingNew(size_t first, Failing failing);
  ~FailingNew() { Stop(); }
  FailingNew(const FailingNew&) = delete;
  FailingNew& operator=(const FailingNew&) = delete;

  // From now on no allocation fails.
  void Stop();
  // Whether an allocation has failed.
  bool has_failed() const;
};

// How many allocations by operator new are not deleted.
ptrdiff_t LiveAllocations();

}  // namespace curvd::testing
