// Plays any sequence of messages to the server's protocol. Each step is an opcode and its operands: raw bytes as a
// message, a header, the next chunk in order, or the half-close.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "curvature/v1/curvature.pb.h"
#include "server/call/request_session.h"
#include "tests/byte_buffers.h"
#include "tests/fuzz/error_properties.h"
#include "tests/fuzz/input.h"
#include "tests/fuzz/require.h"

namespace {

namespace v1 = curvature::v1;
using curvd::Cloud;
using curvd::RequestSession;

constexpr curvd::CallLimits kLimits = {500, 4096, 100, 1 << 30, 10};
constexpr size_t kMaxChunkPoints = 32;

// A chunk whose index is right; its arrays are those that the header asks for, unless the shape says otherwise, and as
// long as the input allows.
v1::PointChunk NextChunk(const RequestSession& session, fuzz::Input& input) {
  const bool is_double = session.has_header() && session.options().scalar_type == curvd::ScalarType::kFloat64;
  const uint8_t shape = input.Byte();
  const size_t bytes = shape % kMaxChunkPoints * (is_double ? 24 : 12);
  v1::PointChunk chunk;
  chunk.set_is_last(shape >= 128);
  chunk.set_first_index(session.points_received());
  chunk.set_positions(std::string(input.Bytes(bytes)));
  const bool is_odd = (shape & 64) != 0;
  const bool has_normals = !session.has_header() || session.options().has_normals();
  const bool has_viewpoints = session.has_header() && session.options().has_viewpoints();
  if (has_normals != is_odd) chunk.set_normals(std::string(input.Bytes(bytes)));
  if (has_viewpoints) chunk.set_viewpoints(std::string(input.Bytes(bytes)));
  const size_t count = bytes / (is_double ? 24 : 12);
  const curvd::CloudPart part = session.has_header() ? session.options().part : curvd::CloudPart();
  if (part.has_ids != is_odd) chunk.set_ids(std::string(input.Bytes(8 * count)));
  if (part.has_roles) chunk.set_roles(std::string(input.Bytes(count)));
  return chunk;
}

// The next message as it comes over the wire; nothing at the half-close.
std::optional<std::string> NextMessage(const RequestSession& session, fuzz::Input& input) {
  v1::EstimateCurvatureRequest message;
  switch (input.Byte() % 4) {
    case 0:
      return std::string(input.Block());
    case 1: {
      const std::string_view bytes = input.Block();
      // Without a header that can be parsed, bytes that cannot are the message.
      if (!message.mutable_header()->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
        return std::string(bytes);
      }
      return message.SerializeAsString();
    }
    case 2:
      *message.mutable_chunk() = NextChunk(session, input);
      return message.SerializeAsString();
    default:
      return std::nullopt;
  }
}

// Gives the session its next message, in pieces; nothing at the half-close.
std::optional<absl::Status> NextStep(RequestSession& session, fuzz::Input& input) {
  const std::optional<std::string> bytes = NextMessage(session, input);
  if (!bytes) return std::nullopt;
  constexpr size_t kPieceBytes = 37;
  grpc::ByteBuffer message = curvd::ToByteBuffer(*bytes, kPieceBytes);
  return session.Receive(message);
}

void CheckPoint(const Cloud& cloud, size_t i, size_t& invalid) {
  if (std::isnan(cloud.position(i)[0])) {
    ++invalid;
    return;
  }
  double length2 = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    fuzz::Require(std::isfinite(cloud.position(i)[axis]), "the positions of valid points are finite");
    if (!cloud.has_normals()) continue;
    length2 += static_cast<double>(cloud.normal(i)[axis]) * cloud.normal(i)[axis];
  }
  if (!cloud.has_normals()) return;
  fuzz::Require(std::abs(length2 - 1.0) < 1e-6, "the normals of valid points have unit length, to float rounding");
}

void CheckViewpoints(const Cloud& cloud, const curvd::Viewpoints& viewpoints) {
  fuzz::Require(viewpoints.size() == cloud.size(), "every point has a viewpoint");
  for (size_t i = 0; i < cloud.size(); ++i) {
    fuzz::Require(std::isnan(cloud.position(i)[0]) || viewpoints.FiniteRun(i, 1) == 1,
                  "the viewpoints of valid points are finite");
  }
}

// Ranks follow the ids, and slots the order of the queries.
void CheckRanks(Cloud& cloud) {
  const size_t queries = cloud.point_set().query_count(), size = cloud.size();
  if (!cloud.Rank().ok()) return;  // two points of one id
  const curvd::PointSet set = cloud.TakePointSet();
  fuzz::Require(set.size() == size, "every point has a rank");
  std::vector<bool> taken(queries), placed(size);
  for (size_t i = 0; i < size; ++i) {
    const auto rank = static_cast<int32_t>(i);
    fuzz::Require(i == 0 || set.seed_of(rank - 1) < set.seed_of(rank), "ranks are in the order of the ids");
    fuzz::Require(set.place_of(rank) < size && !placed[set.place_of(rank)], "ranks are a permutation");
    placed[set.place_of(rank)] = true;
    if (!set.is_query(rank)) continue;
    fuzz::Require(set.slot_of(rank) < queries && !taken[set.slot_of(rank)], "every query has a slot of its own");
    taken[set.slot_of(rank)] = true;
  }
}

void CheckCloud(const RequestSession& session, const Cloud& cloud) {
  fuzz::Require(cloud.size() == session.points_received(), "the cloud holds the points that were received");
  const uint64_t declared = session.options().point_count;
  fuzz::Require(declared == 0 || cloud.size() == declared, "the cloud holds the points that were declared");
  size_t invalid = 0;
  for (size_t i = 0; i < cloud.size(); ++i) CheckPoint(cloud, i, invalid);
  fuzz::Require(invalid == cloud.invalid_count(), "invalid points are counted");
  fuzz::Require(invalid == 0 || session.options().invalid_point_policy == curvd::InvalidPointPolicy::kSkip,
                "a cloud holds invalid points only if they were to be skipped");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  fuzz::Input input(bytes, size);
  RequestSession session(kLimits);
  absl::Status status;
  while (!input.empty()) {
    const std::optional<absl::Status> received = NextStep(session, input);
    if (!received) break;
    fuzz::Require(status.ok() || *received == status, "a session that failed stays so");
    status = *received;
    fuzz::Require(session.points_received() <= kLimits.max_points, "no cloud is over max_points");
  }
  const absl::Status closed = session.HalfClose();
  fuzz::Require(status.ok() || closed == status, "a session that failed stays so");
  if (closed.ok()) {
    Cloud cloud = session.TakeCloud();
    CheckCloud(session, cloud);
    if (session.options().has_viewpoints()) CheckViewpoints(cloud, session.TakeViewpoints());
    CheckRanks(cloud);
  } else {
    fuzz::CheckRequestError(closed);
  }
  return 0;
}
