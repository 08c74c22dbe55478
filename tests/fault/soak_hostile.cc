#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/fault/soak_load.h"
#include "tests/fault/token_file.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using std::chrono::milliseconds;

constexpr size_t kManyPoints = 200'000;
// All memory that one call may have of 2 GiB.
constexpr uint64_t kPointsOfAllMemory = 18'000'000;

const FaultCloud& EqualPoints() {
  static const FaultCloud& cloud = *[] {
    auto* made = new FaultCloud(kManyPoints, 21);
    std::fill(made->positions.begin(), made->positions.end(), 1.0f);
    return made;
  }();
  return cloud;
}

const FaultCloud& ManyPoints() {
  static const FaultCloud& cloud = *new FaultCloud(kManyPoints, 22);
  return cloud;
}

v1::CloudHeader HeaderFor(uint64_t points) {
  v1::CloudHeader header;
  header.set_point_count(points);
  header.set_priority(v1::PRIORITY_INTERACTIVE);
  return header;
}

// Work that takes minutes, broken off after a while.
void Expensive(RawCall& call, std::mt19937_64& random) {
  v1::CloudHeader header = HeaderFor(kManyPoints);
  header.mutable_options()->set_neighbor_count(1'000);
  if (call.SendHeader(header)) call.SendCloud(ManyPoints());
  call.HalfClose();
  std::this_thread::sleep_for(milliseconds(random() % 2'000));
}

void Duplicates(RawCall& call, std::mt19937_64& random) {
  v1::CloudHeader header = HeaderFor(kManyPoints);
  header.mutable_options()->set_estimator(random() % 2 == 0 ? v1::ESTIMATOR_DELAUNAY : v1::ESTIMATOR_UNIFORM);
  if (call.SendHeader(header)) call.SendCloud(EqualPoints());
  call.HalfClose();
  call.ReadFirstResult();
}

// Holds all memory for nothing.
void Holder(RawCall& call) {
  if (!call.SendHeader(HeaderFor(kPointsOfAllMemory))) return;
  for (int i = 0; i < 20 && call.SendPoints(EqualPoints(), 0, 0); ++i) std::this_thread::sleep_for(milliseconds(100));
}

}  // namespace

void MakeHostileCall(const std::string& address, std::mt19937_64& random, SoakCounts& counts) {
  thread_local const std::shared_ptr<grpc::Channel> channel = OwnChannel(address);
  const uint64_t kind = random() % 6;
  // Calls that are broken off at once come in numbers.
  const int calls = kind == 0 ? 50 : 1;
  for (int i = 0; i < calls; ++i) {
    RawCall call(channel);
    if (kind != 1) call.context().AddMetadata("authorization", BearerOf("bob"));
    ++counts.hostile;
    if (kind == 0) call.Start();
    if (kind == 1 && call.SendHeader(HeaderFor(kManyPoints))) call.SendCloud(ManyPoints());
    if (kind == 2) Holder(call);
    if (kind == 3) Duplicates(call, random);
    if (kind > 3) Expensive(call, random);
    call.Cancel();
    const grpc::Status status = call.Finish();
    if (status.error_code() == grpc::StatusCode::INTERNAL) counts.Find("mallory: " + status.error_message());
  }
}

}  // namespace curvd
