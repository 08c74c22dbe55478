// One EstimateCurvature call that may do what a decent client would not: stop anywhere, lie, or not read.
#pragma once

#include <grpcpp/grpcpp.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/cloud/cloud.h"
#include "core/estimators/curvature_field.h"
#include "curvature/v1/curvature.grpc.pb.h"

namespace curvd {

// Points on a wavy sphere, x y z in float, and their outward normals. Two clouds of one seed and size are equal.
struct FaultCloud {
  std::vector<float> positions;
  std::vector<float> normals;

  FaultCloud(size_t points, uint64_t seed);
  size_t size() const { return positions.size() / 3; }
  Cloud ToCloud() const;
};

// 128 bits for each array of results: equal if every byte is equal.
class ResultDigest {
 public:
  void Take(const curvature::v1::ResultChunk& chunk);
  bool operator==(const ResultDigest&) const = default;

  // What a server must send for `field`.
  static ResultDigest Of(const CurvatureField& field);

 private:
  struct Pair {
    uint64_t a = 0x9E3779B97F4A7C15u, b = 0xC2B2AE3D27D4EB4Fu;
    bool operator==(const Pair&) const = default;
    void Take(const std::string& bytes);
  };
  std::array<Pair, 8> arrays_;
};

// Not thread-safe, save for Cancel.
class RawCall {
 public:
  explicit RawCall(const std::shared_ptr<grpc::Channel>& channel);
  ~RawCall();

  // To be changed before the call starts.
  grpc::ClientContext& context() { return context_; }
  // What is sent first starts the call too.
  void Start();
  // Each returns false once the call has ended.
  bool SendHeader(const curvature::v1::CloudHeader& header);
  bool SendPoints(const FaultCloud& cloud, size_t first, size_t count);
  bool SendCloud(const FaultCloud& cloud);
  void HalfClose();
  bool Read(curvature::v1::EstimateCurvatureResponse& message) { return stream_->Read(&message); }
  // Reads until there is a result or the end; true: a result is in digest().
  bool ReadFirstResult();
  // Reads to the end.
  grpc::Status Finish();
  void Cancel() { context_.TryCancel(); }

  const ResultDigest& digest() const { return digest_; }
  const std::optional<curvature::v1::Summary>& summary() const { return summary_; }

 private:
  bool Take(const curvature::v1::EstimateCurvatureResponse& message);

  std::unique_ptr<curvature::v1::CurvatureService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<
      grpc::ClientReaderWriter<curvature::v1::EstimateCurvatureRequest, curvature::v1::EstimateCurvatureResponse>>
      stream_;
  curvature::v1::EstimateCurvatureRequest request_;
  bool half_closed_ = false;
  bool finished_ = false;
  ResultDigest digest_;
  std::optional<curvature::v1::Summary> summary_;
};

// A channel that shares its connection with no other.
std::shared_ptr<grpc::Channel> OwnChannel(const std::string& address);

}  // namespace curvd
