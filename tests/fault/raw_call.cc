#include "tests/fault/raw_call.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/fault/curvd_child.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr size_t kChunkPoints = 10'000;

std::string Pack(const std::vector<float>& values, size_t first, size_t count) {
  return {reinterpret_cast<const char*>(values.data() + 3 * first), 3 * count * sizeof(float)};
}

// The values of member `field` of all points, as the wire has them.
template <typename Field>
std::string Pack(const CurvatureField& points, Field PointCurvature::*field) {
  std::string bytes;
  bytes.reserve(points.points.size() * sizeof(Field));
  for (const PointCurvature& point : points.points.span()) {
    bytes.append(reinterpret_cast<const char*>(&(point.*field)), sizeof(Field));
  }
  return bytes;
}

}  // namespace

FaultCloud::FaultCloud(size_t points, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  positions.reserve(3 * points);
  normals.reserve(3 * points);
  for (size_t i = 0; i < points; ++i) {
    const double x = normal(random), y = normal(random), z = normal(random);
    const double length = std::sqrt(x * x + y * y + z * z);
    const double radius = 1.0 + 0.05 * std::sin(5.0 * x / length);
    for (const double coordinate : {x, y, z}) {
      positions.push_back(static_cast<float>(radius * coordinate / length));
      normals.push_back(static_cast<float>(coordinate / length));
    }
  }
}

Cloud FaultCloud::ToCloud() const {
  Cloud cloud;
  // In pieces, so that no second copy of a large cloud is made.
  for (size_t first = 0; first < size(); first += kChunkPoints) {
    const size_t count = std::min(kChunkPoints, size() - first);
    if (!cloud.Append(Pack(positions, first, count), Pack(normals, first, count)).ok()) Fail("the cloud is refused");
  }
  if (!cloud.Finish().ok()) Fail("the cloud is refused");
  return cloud;
}

void ResultDigest::Pair::Take(const std::string& bytes) {
  size_t i = 0;
  const auto mix = [this](uint32_t word) {
    a = (a ^ word) * 0x100000001B3u;
    a ^= a >> 29;
    b = (b + word) * 0xFF51AFD7ED558CCDu;
    b ^= b >> 32;
  };
  for (uint32_t word = 0; i + sizeof(word) <= bytes.size(); i += sizeof(word)) {
    std::memcpy(&word, bytes.data() + i, sizeof(word));
    mix(word);
  }
  for (; i < bytes.size(); ++i) mix(static_cast<unsigned char>(bytes[i]));
}

void ResultDigest::Take(const v1::ResultChunk& chunk) {
  const std::string* arrays[] = {
      &chunk.mean_curvature(), &chunk.gaussian_curvature(), &chunk.k1(), &chunk.k2(), &chunk.d1(), &chunk.d2(),
      &chunk.radius()};
  for (size_t i = 0; i < std::size(arrays); ++i) arrays_[i].Take(*arrays[i]);
  // Byte by byte, since chunks may end within a word.
  for (const char status : chunk.status()) arrays_.back().Take(std::string(1, status));
}

ResultDigest ResultDigest::Of(const CurvatureField& field) {
  v1::ResultChunk chunk;
  chunk.set_mean_curvature(Pack(field, &PointCurvature::mean));
  chunk.set_gaussian_curvature(Pack(field, &PointCurvature::gaussian));
  chunk.set_k1(Pack(field, &PointCurvature::k1));
  chunk.set_k2(Pack(field, &PointCurvature::k2));
  chunk.set_d1(Pack(field, &PointCurvature::d1));
  chunk.set_d2(Pack(field, &PointCurvature::d2));
  chunk.set_radius(Pack(field, &PointCurvature::radius));
  chunk.set_status(Pack(field, &PointCurvature::status));
  ResultDigest digest;
  digest.Take(chunk);
  return digest;
}

RawCall::RawCall(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::CurvatureService::NewStub(channel)), stream_(nullptr) {}

void RawCall::Start() {
  if (stream_ == nullptr) stream_ = stub_->EstimateCurvature(&context_);
}

RawCall::~RawCall() {
  if (stream_ == nullptr || finished_) return;
  Cancel();
  Finish();
}

bool RawCall::SendHeader(const v1::CloudHeader& header) {
  Start();
  *request_.mutable_header() = header;
  return stream_->Write(request_);
}

bool RawCall::SendPoints(const FaultCloud& cloud, size_t first, size_t count) {
  Start();
  v1::PointChunk& chunk = *request_.mutable_chunk();
  chunk.set_first_index(first);
  chunk.set_positions(Pack(cloud.positions, first, count));
  chunk.set_normals(Pack(cloud.normals, first, count));
  return stream_->Write(request_);
}

bool RawCall::SendCloud(const FaultCloud& cloud) {
  for (size_t first = 0; first < cloud.size(); first += kChunkPoints) {
    if (!SendPoints(cloud, first, std::min(kChunkPoints, cloud.size() - first))) return false;
  }
  return true;
}

void RawCall::HalfClose() {
  if (!std::exchange(half_closed_, true)) stream_->WritesDone();
}

bool RawCall::Take(const v1::EstimateCurvatureResponse& message) {
  if (message.has_summary()) summary_ = message.summary();
  if (!message.has_result()) return false;
  digest_.Take(message.result());
  return true;
}

bool RawCall::ReadFirstResult() {
  v1::EstimateCurvatureResponse message;
  while (stream_->Read(&message)) {
    if (Take(message)) return true;
  }
  return false;
}

grpc::Status RawCall::Finish() {
  Start();
  v1::EstimateCurvatureResponse message;
  while (stream_->Read(&message)) Take(message);
  HalfClose();
  finished_ = true;
  return stream_->Finish();
}

std::shared_ptr<grpc::Channel> OwnChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace curvd
