#include "server/call/chunk/append_chunk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace curvd {
namespace {

using curvature::wire::Pieces;

// `bytes` cut after every `piece_bytes`, the first piece `shift` shorter.
Pieces Cut(const std::string& bytes, size_t piece_bytes, size_t shift) {
  Pieces pieces;
  for (size_t at = 0; at < bytes.size();) {
    const size_t size = std::min(at == 0 && shift < piece_bytes ? piece_bytes - shift : piece_bytes, bytes.size() - at);
    pieces.emplace_back(bytes.data() + at, size);
    at += size;
  }
  return pieces;
}

template <typename Scalar>
std::string Packed(size_t points, double offset) {
  std::vector<Scalar> scalars(3 * points);
  for (size_t i = 0; i < scalars.size(); ++i) scalars[i] = static_cast<Scalar>(offset + static_cast<double>(i));
  return {reinterpret_cast<const char*>(scalars.data()), scalars.size() * sizeof(Scalar)};
}

template <typename Scalar>
void CheckAllCuts(ScalarType type) {
  const std::string positions = Packed<Scalar>(200, 0.0), normals = Packed<Scalar>(200, 1.0);
  Cloud whole(type);
  ASSERT_TRUE(whole.Append(positions, normals).ok());
  ASSERT_TRUE(whole.Finish().ok());
  for (const size_t piece_bytes : {1, 5, 11, 12, 13, 24, 100, 1000, 10'000}) {
    for (const size_t shift : {0, 1, 4, 7, 12}) {
      Cloud cut(type);
      const absl::Status status =
          AppendPieces(Cut(positions, piece_bytes, shift), Cut(normals, piece_bytes, 0), type, cut);
      ASSERT_TRUE(status.ok()) << status;
      ASSERT_TRUE(cut.Finish().ok());
      ASSERT_EQ(cut.size(), whole.size());
      for (size_t i = 0; i < whole.size(); ++i) {
        ASSERT_EQ(cut.position(i), whole.position(i)) << i << " of pieces of " << piece_bytes;
        ASSERT_EQ(cut.normal(i), whole.normal(i)) << i << " of pieces of " << piece_bytes;
      }
    }
  }
}

TEST(AppendPiecesTest, CutsChangeNoFloat) { CheckAllCuts<float>(ScalarType::kFloat32); }
TEST(AppendPiecesTest, CutsChangeNoDouble) { CheckAllCuts<double>(ScalarType::kFloat64); }

TEST(AppendPiecesTest, NamesTheInvalidPointWhereverItIsCut) {
  const std::string positions = Packed<float>(10, 0.0);
  std::string normals = Packed<float>(10, 1.0);
  std::memset(normals.data() + 7 * 12, 0, 12);
  for (const size_t piece_bytes : {5, 12, 90, 1000}) {
    Cloud cloud(ScalarType::kFloat32);
    const absl::Status status =
        AppendPieces(Cut(positions, piece_bytes, 0), Cut(normals, piece_bytes, 3), ScalarType::kFloat32, cloud);
    EXPECT_TRUE(absl::IsInvalidArgument(status));
    EXPECT_NE(status.message().find("normal of point 7"), std::string::npos) << status;
    EXPECT_EQ(cloud.size(), 7u);
  }
}

TEST(AppendPiecesTest, TakesPositionsAlone) {
  const std::string positions = Packed<float>(200, 0.0);
  for (const size_t piece_bytes : {1, 5, 12, 13, 100, 10'000}) {
    Cloud cloud(ScalarType::kFloat32, InvalidPointPolicy::kReject, NormalsInput::kAbsent);
    ASSERT_TRUE(AppendPieces(Cut(positions, piece_bytes, 3), {}, ScalarType::kFloat32, cloud).ok());
    ASSERT_TRUE(cloud.Finish().ok());
    ASSERT_EQ(cloud.size(), 200u);
    EXPECT_EQ(cloud.position(199)[2], 599.0f);
  }
}

// Points 3 and 4 of ten were seen from nowhere.
template <typename Scalar>
std::string SeenFrom() {
  std::string viewpoints = Packed<Scalar>(10, 2.0);
  const Scalar nowhere[] = {std::numeric_limits<Scalar>::infinity(), std::numeric_limits<Scalar>::quiet_NaN()};
  std::memcpy(viewpoints.data() + 3 * 3 * sizeof(Scalar), &nowhere[0], sizeof(Scalar));
  std::memcpy(viewpoints.data() + (4 * 3 + 2) * sizeof(Scalar), &nowhere[1], sizeof(Scalar));
  return viewpoints;
}

template <typename Scalar>
void CheckViewpoints(ScalarType type) {
  const std::string positions = Packed<Scalar>(10, 0.0), normals = Packed<Scalar>(10, 1.0), seen = SeenFrom<Scalar>();
  for (const size_t piece_bytes : {5, 12, 90, 1000}) {
    Viewpoints viewpoints;
    ASSERT_TRUE(viewpoints.Append(Cut(seen, piece_bytes, 1), type).ok());
    ASSERT_EQ(viewpoints.size(), 10u);
    EXPECT_EQ(viewpoints[9][2], 31.0);

    Cloud strict(type);
    const absl::Status refused =
        AppendSeenPieces(Cut(positions, piece_bytes, 0), Cut(normals, piece_bytes, 3), type, viewpoints, strict);
    EXPECT_TRUE(absl::IsInvalidArgument(refused));
    EXPECT_NE(refused.message().find("viewpoint of point 3 is (inf, 12, 13)"), std::string::npos) << refused;
    EXPECT_EQ(strict.size(), 3u);

    Cloud lenient(type, InvalidPointPolicy::kSkip);
    ASSERT_TRUE(
        AppendSeenPieces(Cut(positions, piece_bytes, 0), Cut(normals, piece_bytes, 3), type, viewpoints, lenient).ok());
    ASSERT_TRUE(lenient.Finish().ok());
    EXPECT_EQ(lenient.size(), 10u);
    EXPECT_EQ(lenient.invalid_count(), 2u);
    EXPECT_TRUE(std::isnan(lenient.position(4)[0]));
    EXPECT_FALSE(std::isnan(lenient.position(5)[0]));
  }
}

TEST(AppendSeenPiecesTest, APointSeenFromNowhereIsInvalid) { CheckViewpoints<float>(ScalarType::kFloat32); }
TEST(AppendSeenPiecesTest, APointSeenFromNowhereInDoublesIsInvalid) { CheckViewpoints<double>(ScalarType::kFloat64); }

TEST(ViewpointsTest, GrowAsChunksCome) {
  Viewpoints viewpoints;
  const std::string some = Packed<float>(50'000, 0.0);
  for (int chunk = 0; chunk < 3; ++chunk) ASSERT_TRUE(viewpoints.Append({some}, ScalarType::kFloat32).ok());
  ASSERT_EQ(viewpoints.span().size(), 150'000u);
  EXPECT_EQ(viewpoints[100'001][1], 4.0);
  EXPECT_EQ(viewpoints.FiniteRun(0, 150'000), 150'000u);
}

TEST(AppendPiecesTest, TakesNothing) {
  Cloud cloud(ScalarType::kFloat32);
  EXPECT_TRUE(AppendPieces({}, {}, ScalarType::kFloat32, cloud).ok());
  EXPECT_TRUE(AppendPieces({""}, {""}, ScalarType::kFloat32, cloud).ok());
  EXPECT_EQ(cloud.size(), 0u);
}

}  // namespace
}  // namespace curvd
