#include "server/call/wire_normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>

#include "server/rpc/error_reasons.h"
#include "tests/server/status_matchers.h"

namespace curvd {
namespace {

namespace v1 = curvature::v1;

constexpr CallLimits kLimits = {1000, 4096, 100, 1 << 30, 10};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

v1::NormalOptions From(v1::NormalSource source) {
  v1::NormalOptions proto;
  proto.set_source(source);
  return proto;
}

v1::NormalOptions Toward(v1::Orientation orientation) {
  v1::NormalOptions proto = From(v1::NORMAL_SOURCE_ORIENT);
  proto.set_orientation(orientation);
  return proto;
}

void Set(double x, double y, double z, v1::Vector3* vector) {
  vector->set_x(x);
  vector->set_y(y);
  vector->set_z(z);
}

NormalOptions Read(const v1::NormalOptions& proto) {
  NormalOptions options;
  const absl::Status status = ReadNormals(proto, kLimits, options);
  EXPECT_TRUE(status.ok()) << status;
  return options;
}

::testing::AssertionResult Refuses(const v1::NormalOptions& proto, std::initializer_list<std::string> words) {
  NormalOptions options;
  return IsError(ReadNormals(proto, kLimits, options), absl::StatusCode::kInvalidArgument, kReasonInvalidOption, words);
}

TEST(ReadNormalsTest, DefaultsToGivenNormals) {
  const NormalOptions options = Read({});
  EXPECT_EQ(options.source, NormalSource::kGiven);
  EXPECT_TRUE(options.Validate(10).ok());
}

TEST(ReadNormalsTest, LeavesMethodAndNeighborhoodToThePointsByDefault) {
  const NormalOptions options = Read(From(v1::NORMAL_SOURCE_ESTIMATE));
  EXPECT_EQ(options.source, NormalSource::kEstimate);
  EXPECT_FALSE(options.method.has_value());
  EXPECT_TRUE(std::holds_alternative<AutoNeighborhood>(options.neighborhood));
  EXPECT_TRUE(std::holds_alternative<ConsistentSides>(options.sides));
  EXPECT_EQ(options.max_neighbor_count, 100u);
}

TEST(ReadNormalsTest, TakesEveryMethodWithItsNeighborhood) {
  const std::pair<v1::NormalMethod, NormalMethod> methods[] = {{v1::NORMAL_METHOD_PCA, NormalMethod::kPca},
                                                               {v1::NORMAL_METHOD_JET_1, NormalMethod::kJet1},
                                                               {v1::NORMAL_METHOD_JET_2, NormalMethod::kJet2},
                                                               {v1::NORMAL_METHOD_JET_4, NormalMethod::kJet4}};
  for (const auto& [wire, method] : methods) {
    v1::NormalOptions proto = From(v1::NORMAL_SOURCE_ESTIMATE);
    proto.set_method(wire);
    const uint32_t least = LeastNeighborCount(method);
    proto.set_neighbor_count(least);
    const NormalOptions options = Read(proto);
    EXPECT_EQ(options.method, method);
    EXPECT_EQ(std::get<NeighborCount>(options.neighborhood).count, least);
    EXPECT_TRUE(options.Validate(10).ok());
    proto.set_neighbor_count(least - 1);
    EXPECT_TRUE(Refuses(proto, {"header.normals.neighbor_count", std::to_string(least - 1),
                                "at least " + std::to_string(least), std::string(NormalMethodName(method))}));
    v1::NormalOptions echo;
    WriteNormals(options, echo);
    EXPECT_EQ(echo.method(), wire);
  }
}

TEST(ReadNormalsTest, TakesARadius) {
  v1::NormalOptions proto = From(v1::NORMAL_SOURCE_ESTIMATE);
  proto.set_radius(0.5);
  EXPECT_EQ(std::get<NeighborRadius>(Read(proto).neighborhood).radius, 0.5);
  for (const double radius : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    proto.set_radius(radius);
    EXPECT_TRUE(Refuses(proto, {"header.normals.radius", "finite and above 0"})) << radius;
  }
}

TEST(ReadNormalsTest, RefusesMoreNeighborsThanTheServerAllows) {
  v1::NormalOptions proto = From(v1::NORMAL_SOURCE_ESTIMATE);
  proto.set_neighbor_count(101);
  NormalOptions options;
  EXPECT_TRUE(IsError(ReadNormals(proto, kLimits, options), absl::StatusCode::kResourceExhausted,
                      kReasonNeighborhoodTooLarge, {"header.normals.neighbor_count", "101", "at most 100"}));
}

TEST(ReadNormalsTest, RefusesUnknownValues) {
  EXPECT_TRUE(Refuses(From(static_cast<v1::NormalSource>(4)), {"header.normals.source", "4", "3 (estimate)"}));
  v1::NormalOptions method = From(v1::NORMAL_SOURCE_ESTIMATE);
  method.set_method(static_cast<v1::NormalMethod>(5));
  EXPECT_TRUE(Refuses(method, {"header.normals.method", "5", "PCA"}));
  EXPECT_TRUE(Refuses(Toward(static_cast<v1::Orientation>(6)), {"header.normals.orientation", "6", "5 (direction)"}));
}

TEST(ReadNormalsTest, RefusesWhatWouldHaveNoEffect) {
  v1::NormalOptions method = From(v1::NORMAL_SOURCE_ORIENT);
  method.set_method(v1::NORMAL_METHOD_PCA);
  EXPECT_TRUE(Refuses(method, {"header.normals.method", "1", "header.normals.source is 3 (estimate)"}));
  v1::NormalOptions count = From(v1::NORMAL_SOURCE_GIVEN);
  count.set_neighbor_count(20);
  EXPECT_TRUE(Refuses(count, {"header.normals.neighbor_count", "20", "header.normals.source"}));
  v1::NormalOptions radius;
  radius.set_radius(2.0);
  EXPECT_TRUE(Refuses(radius, {"header.normals.radius", "2", "header.normals.source"}));
  v1::NormalOptions orientation;
  orientation.set_orientation(v1::ORIENTATION_CONSISTENT);
  EXPECT_TRUE(Refuses(orientation, {"header.normals.orientation", "1", "2 (orient) or 3 (estimate)"}));
  v1::NormalOptions viewpoint = From(v1::NORMAL_SOURCE_ESTIMATE);
  Set(1.0000001, 2, 3, viewpoint.mutable_viewpoint());
  EXPECT_TRUE(Refuses(viewpoint, {"header.normals.viewpoint", "(1.0000001, 2, 3)", "header.normals.orientation is 3"}));
  v1::NormalOptions direction = Toward(v1::ORIENTATION_CLOSED);
  Set(0, 0, 1, direction.mutable_direction());
  EXPECT_TRUE(Refuses(direction, {"header.normals.direction", "0, 0, 1", "header.normals.orientation is 5"}));
}

TEST(ReadNormalsTest, TakesAFiniteViewpoint) {
  v1::NormalOptions proto = Toward(v1::ORIENTATION_VIEWPOINT);
  EXPECT_TRUE(Refuses(proto, {"header.normals.viewpoint", "unset"}));
  Set(1, 2, 3, proto.mutable_viewpoint());
  EXPECT_EQ(std::get<SidesTowardViewpoint>(Read(proto).sides).viewpoint, (std::array<double, 3>{1, 2, 3}));
  Set(1, kNan, 3, proto.mutable_viewpoint());
  EXPECT_TRUE(Refuses(proto, {"header.normals.viewpoint", "1, nan, 3", "finite"}));
}

TEST(ReadNormalsTest, TakesADirectionThatIsNotZero) {
  v1::NormalOptions proto = Toward(v1::ORIENTATION_DIRECTION);
  EXPECT_TRUE(Refuses(proto, {"header.normals.direction", "unset"}));
  Set(0, 0, 0, proto.mutable_direction());
  EXPECT_TRUE(Refuses(proto, {"header.normals.direction", "0, 0, 0", "not zero"}));
  Set(0, 0, -1e-300, proto.mutable_direction());
  EXPECT_EQ(std::get<SidesAlongDirection>(Read(proto).sides).direction, (std::array<double, 3>{0, 0, -1e-300}));
}

TEST(WriteNormalsTest, TellsEveryOrientation) {
  for (const v1::Orientation orientation :
       {v1::ORIENTATION_CONSISTENT, v1::ORIENTATION_CLOSED, v1::ORIENTATION_VIEWPOINT, v1::ORIENTATION_POINT_VIEWPOINTS,
        v1::ORIENTATION_DIRECTION}) {
    v1::NormalOptions proto = Toward(orientation);
    if (orientation == v1::ORIENTATION_VIEWPOINT) Set(1, 2, 3, proto.mutable_viewpoint());
    if (orientation == v1::ORIENTATION_DIRECTION) Set(0, 0, 2, proto.mutable_direction());
    v1::NormalOptions echo;
    WriteNormals(Read(proto), echo);
    EXPECT_EQ(echo.SerializeAsString(), proto.SerializeAsString()) << echo.DebugString();
  }
}

TEST(WriteNormalsTest, TellsOfGivenNormalsThatTheyAre) {
  v1::NormalOptions echo;
  WriteNormals(NormalOptions(), echo);
  EXPECT_EQ(echo.SerializeAsString(), From(v1::NORMAL_SOURCE_GIVEN).SerializeAsString());
}

TEST(WriteReportTest, TellsWhatWasFound) {
  NormalReport report;
  report.method = NormalMethod::kJet4;
  report.neighbor_count = 24;
  report.sigma = 0.125;
  report.status_counts[static_cast<size_t>(PointStatus::kOk)] = 7;
  report.status_counts[static_cast<size_t>(PointStatus::kSingularFit)] = 2;
  report.flipped_count = 3;
  report.piece_count = 2;
  report.closed_piece_count = 1;
  report.closed_area_share = 0.75;
  report.repaired_count = 5;
  report.noisy_part = {NormalMethod::kJet2, 192, 0.5, 0.25};
  v1::NormalsReport proto;
  WriteReport(report, proto);
  EXPECT_EQ(proto.method(), v1::NORMAL_METHOD_JET_4);
  EXPECT_EQ(proto.neighbor_count(), 24u);
  EXPECT_EQ(proto.noise(), 0.125);
  EXPECT_EQ(proto.missing_count(), 2u);
  EXPECT_EQ(proto.turned_count(), 0u) << "says nothing of estimated normals";
  EXPECT_EQ(proto.piece_count(), 2u);
  EXPECT_EQ(proto.closed_piece_count(), 1u);
  EXPECT_EQ(proto.closed_area_share(), 0.75);
  EXPECT_EQ(proto.repaired_count(), 5u);
  EXPECT_FALSE(proto.has_certificate() || proto.doubtful());
  EXPECT_EQ(proto.noisy_part().method(), v1::NORMAL_METHOD_JET_2);
  EXPECT_EQ(proto.noisy_part().neighbor_count(), 192u);
  EXPECT_EQ(proto.noisy_part().noise(), 0.5);
  EXPECT_EQ(proto.noisy_part().share(), 0.25);
}

}  // namespace
}  // namespace curvd
