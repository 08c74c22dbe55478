#include "tests/fault/soak_load.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "tests/fault/curvd_child.h"
#include "tests/fault/token_file.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;
using grpc::StatusCode;

std::shared_ptr<grpc::Channel> SomeChannel(const std::string& address, std::mt19937_64& random) {
  thread_local std::shared_ptr<grpc::Channel> channel;
  if (channel == nullptr || random() % 16 == 0) channel = OwnChannel(address);
  return channel;
}

// Small clouds often, large ones seldom.
const SoakCase& Pick(const std::vector<SoakCase>& cases, std::mt19937_64& random) {
  const size_t first = random() % cases.size(), second = random() % cases.size();
  return cases[std::min(first, second)];
}

bool AsksToWait(const grpc::Status& status) { return status.error_code() == StatusCode::RESOURCE_EXHAUSTED; }

std::string Describe(const SoakCase& work, const grpc::Status& status) {
  return absl::StrCat(work.cloud->size(), " points, ", v1::Estimator_Name(work.header.options().estimator()), ": code ",
                      status.error_code(), " ", status.error_message());
}

void Judge(const SoakCase& work, RawCall& call, const grpc::Status& status, SoakCounts& counts) {
  if (AsksToWait(status)) {
    ++counts.asked_to_wait;
  } else if (!status.ok()) {
    counts.Find(Describe(work, status));
  } else if (!call.summary() || !(call.digest() == work.expected)) {
    counts.Find("a wrong byte: " + Describe(work, status));
  } else {
    ++counts.right;
    counts.points += work.cloud->size();
  }
}

void GoodCall(RawCall& call, const SoakCase& work, std::mt19937_64& random, SoakCounts& counts) {
  v1::CloudHeader header = work.header;
  if (random() % 3 == 0) header.clear_point_count();
  header.set_priority(static_cast<v1::Priority>(random() % 3));
  if (call.SendHeader(header)) call.SendCloud(*work.cloud);
  call.HalfClose();
  Judge(work, call, call.Finish(), counts);
}

// An end that comes at any time is right, as is a result that came before it.
void JudgeEnd(const SoakCase& work, RawCall& call, StatusCode expected, std::atomic<uint64_t>& count,
              SoakCounts& counts) {
  const grpc::Status status = call.Finish();
  if (status.error_code() == expected) {
    ++count;
  } else {
    Judge(work, call, status, counts);
  }
}

void CancelledCall(RawCall& call, const SoakCase& work, std::mt19937_64& random, SoakCounts& counts) {
  call.SendHeader(work.header);
  std::jthread canceller([&call, wait = random() % 200] {
    std::this_thread::sleep_for(std::chrono::milliseconds(wait));
    call.Cancel();
  });
  call.SendCloud(*work.cloud);
  call.HalfClose();
  JudgeEnd(work, call, StatusCode::CANCELLED, counts.cancelled, counts);
}

void HastyCall(RawCall& call, const SoakCase& work, std::mt19937_64& random, SoakCounts& counts) {
  call.context().set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(random() % 200));
  if (call.SendHeader(work.header)) call.SendCloud(*work.cloud);
  call.HalfClose();
  JudgeEnd(work, call, StatusCode::DEADLINE_EXCEEDED, counts.timed_out, counts);
}

void BadCall(RawCall& call, const SoakCase& work, std::mt19937_64& random, SoakCounts& counts) {
  v1::CloudHeader header = work.header;
  const FaultCloud& cloud = *work.cloud;
  switch (random() % 4) {
    case 0:
      header.mutable_options()->set_neighbor_count(3);
      call.SendHeader(header);
      break;
    case 1:
      call.SendPoints(cloud, 0, 1);
      break;
    case 2:
      call.SendHeader(header);
      call.SendCloud(cloud);
      call.SendPoints(cloud, 0, 1);
      break;
    default: {
      FaultCloud damaged(std::min<size_t>(cloud.size(), 1'000), 5);
      damaged.positions[random() % damaged.positions.size()] = std::numeric_limits<float>::quiet_NaN();
      header.clear_point_count();
      call.SendHeader(header);
      call.SendCloud(damaged);
    }
  }
  call.HalfClose();
  JudgeEnd(work, call, StatusCode::INVALID_ARGUMENT, counts.refused_input, counts);
}

// Announces a cloud and sends chunks without points, until the server has had enough.
void HoldingCall(RawCall& call, const SoakCase& work, SoakCounts& counts) {
  if (call.SendHeader(work.header)) {
    while (call.SendPoints(*work.cloud, 0, 0)) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  JudgeEnd(work, call, StatusCode::DEADLINE_EXCEEDED, counts.stalled, counts);
}

// Sends a cloud and reads nothing, or opens a call and sends nothing, until the server has had enough.
void StalledCall(RawCall& call, int stall_seconds, const SoakCase& work, std::mt19937_64& random, SoakCounts& counts) {
  call.SendHeader(work.header);
  if (random() % 2 == 0) {
    call.SendCloud(*work.cloud);
    call.HalfClose();
    std::this_thread::sleep_for(std::chrono::seconds(stall_seconds + 1));
    // A small result fits into the buffers on the way; a large one was cut off, with or without its status.
    const grpc::Status status = call.Finish();
    status.ok() ? Judge(work, call, status, counts) : static_cast<void>(++counts.stalled);
  } else {
    JudgeEnd(work, call, StatusCode::DEADLINE_EXCEEDED, counts.stalled, counts);
  }
}

}  // namespace

void SoakCounts::Find(std::string what) {
  const std::lock_guard lock(mutex_);
  if (finding_.empty()) finding_ = std::move(what);
}

std::string SoakCounts::finding() const {
  const std::lock_guard lock(mutex_);
  return finding_;
}

void MakeSoakCall(const std::string& address, int stall_seconds, const std::vector<SoakCase>& cases,
                  std::mt19937_64& random, SoakCounts& counts) {
  const SoakCase& work = Pick(cases, random);
  RawCall call(SomeChannel(address, random));
  call.context().AddMetadata("authorization", BearerOf("alice"));
  // Nobody new is let in while strangers' attacks have used up the memory, which is over soon.
  call.context().set_wait_for_ready(true);
  const uint64_t kind = random() % 100;
  if (kind < 60) return GoodCall(call, work, random, counts);
  if (kind < 76) return CancelledCall(call, work, random, counts);
  if (kind < 87) return HastyCall(call, work, random, counts);
  if (kind < 99) return BadCall(call, work, random, counts);
  // Few, since each keeps its client for seconds, in which others have to keep the server busy.
  if (random() % 3 == 0) return HoldingCall(call, work, counts);
  StalledCall(call, stall_seconds, work, random, counts);
}

}  // namespace curvd
