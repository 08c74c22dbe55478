// The calls of a soak: good ones whose every byte is known beforehand, all kinds of bad ones, and those of a caller who
// wants to harm the others.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <vector>

#include "curvature/v1/curvature.pb.h"
#include "tests/fault/raw_call.h"

namespace curvd {

// A cloud, options, and what a server must answer. Immutable.
struct SoakCase {
  std::shared_ptr<const FaultCloud> cloud;
  curvature::v1::CloudHeader header;
  ResultDigest expected;
};

// Clouds of 1 to `max_points` points, each with every estimator that takes seconds at most, computed in this process.
// Some are such as cost most: of equal points, half of them at zero, with one far outside.
std::vector<SoakCase> MakeSoakCases(size_t max_points);

// What came of the calls. Thread-safe.
struct SoakCounts {
  std::atomic<uint64_t> right = 0;
  std::atomic<uint64_t> cancelled = 0;
  std::atomic<uint64_t> timed_out = 0;
  std::atomic<uint64_t> refused_input = 0;
  std::atomic<uint64_t> stalled = 0;
  std::atomic<uint64_t> asked_to_wait = 0;
  std::atomic<uint64_t> hostile = 0;
  std::atomic<uint64_t> points = 0;  // of right results

  void Find(std::string what);
  // The first finding, or "".
  std::string finding() const;

 private:
  mutable std::mutex mutex_;
  std::string finding_;  // guarded by mutex_
};

// Makes one call of alice's of a random kind and judges its answer. `address`: where curvd serves, with the tokens of
// TokenFile; `stall_seconds`: after which it ends stalled calls.
void MakeSoakCall(const std::string& address, int stall_seconds, const std::vector<SoakCase>& cases,
                  std::mt19937_64& random, SoakCounts& counts);

// Makes one call, or some, of mallory's, who has bob's token or none, and takes what work and memory he can get, for a
// second or two. Whatever his calls end with is right, but an INTERNAL error.
void MakeHostileCall(const std::string& address, std::mt19937_64& random, SoakCounts& counts);

}  // namespace curvd
