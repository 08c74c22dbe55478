#include "server/call/append_chunk.h"

#include <gtest/gtest.h>

#include <cstring>
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

TEST(AppendPiecesTest, TakesNothing) {
  Cloud cloud(ScalarType::kFloat32);
  EXPECT_TRUE(AppendPieces({}, {}, ScalarType::kFloat32, cloud).ok());
  EXPECT_TRUE(AppendPieces({""}, {""}, ScalarType::kFloat32, cloud).ok());
  EXPECT_EQ(cloud.size(), 0u);
}

}  // namespace
}  // namespace curvd
