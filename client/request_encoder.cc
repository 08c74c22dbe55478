#include "client/request_encoder.h"

#include <array>
#include <cstring>
#include <string>
#include <variant>

#include "curvature/v1/curvature.pb.h"
#include "proto/bulk_message.h"
#include "proto/result_columns.h"

namespace curv {

static_assert(static_cast<int>(PointRole::kQuery) == curvature::v1::POINT_ROLE_QUERY);
static_assert(static_cast<int>(PointRole::kHalo) == curvature::v1::POINT_ROLE_HALO);

namespace {

namespace v1 = curvature::v1;

v1::Priority ToProto(Priority priority) {
  switch (priority) {
    case Priority::kBySize:
      return v1::PRIORITY_UNSPECIFIED;
    case Priority::kInteractive:
      return v1::PRIORITY_INTERACTIVE;
    case Priority::kBatch:
      return v1::PRIORITY_BATCH;
  }
  return v1::PRIORITY_UNSPECIFIED;
}

void Set(const std::array<double, 3>& from, v1::Vector3* to) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

void FillOrientation(const NormalOptions& options, v1::NormalOptions& proto) {
  if (const auto* consistent = std::get_if<ConsistentSides>(&options.sides)) {
    proto.set_orientation(consistent->closed ? v1::ORIENTATION_CLOSED : v1::ORIENTATION_CONSISTENT);
  } else if (const auto* one = std::get_if<SidesTowardViewpoint>(&options.sides)) {
    proto.set_orientation(v1::ORIENTATION_VIEWPOINT);
    Set(one->viewpoint, proto.mutable_viewpoint());
  } else if (const auto* along = std::get_if<SidesAlongDirection>(&options.sides)) {
    proto.set_orientation(v1::ORIENTATION_DIRECTION);
    Set(along->direction, proto.mutable_direction());
  } else {
    proto.set_orientation(v1::ORIENTATION_POINT_VIEWPOINTS);
  }
}

void FillNormals(const NormalOptions& options, v1::NormalOptions& proto) {
  proto.set_source(static_cast<v1::NormalSource>(options.source));
  FillOrientation(options, proto);
  if (options.source != NormalSource::kEstimate) return;
  if (options.method) proto.set_method(static_cast<v1::NormalMethod>(*options.method));
  if (options.radius) {
    proto.set_radius(*options.radius);
  } else if (options.neighbor_count != 0) {
    proto.set_neighbor_count(options.neighbor_count);
  }
}

void Fill(const AutomaticScale& scale, v1::AutomaticScale& proto) {
  proto.set_least_neighbor_count(scale.least_neighbor_count);
  proto.set_most_neighbor_count(scale.most_neighbor_count);
  proto.set_max_radius(scale.max_radius);
  proto.set_per_cloud(scale.per_cloud);
}

}  // namespace

grpc::Slice PackHeader(const CloudView& cloud, const EstimateOptions& options) {
  v1::EstimateCurvatureRequest request;
  v1::CloudHeader& header = *request.mutable_header();
  header.set_point_count(cloud.size());
  header.set_scalar_type(cloud.is_double() ? v1::SCALAR_TYPE_FLOAT64 : v1::SCALAR_TYPE_FLOAT32);
  Set(options.origin, header.mutable_origin());
  v1::EstimatorOptions& estimator = *header.mutable_options();
  estimator.set_estimator(static_cast<v1::Estimator>(options.estimator));
  if (!options.neighbor_counts.empty()) {
    estimator.mutable_neighbor_counts()->Assign(options.neighbor_counts.begin(), options.neighbor_counts.end());
  } else if (options.automatic_scale) {
    Fill(*options.automatic_scale, *estimator.mutable_automatic_scale());
  } else if (options.radius) {
    estimator.set_radius(*options.radius);
  } else {
    estimator.set_neighbor_count(options.neighbor_count);
  }
  estimator.set_triangle_count(options.triangle_count);
  estimator.set_rotation_count(options.rotation_count);
  if (options.jet_degree) estimator.set_jet_degree(*options.jet_degree);
  estimator.set_regression_degree(options.regression_degree);
  estimator.set_even_weights(options.even_weights);
  estimator.set_project(options.project);
  estimator.set_seed(options.seed);
  if (options.average_normal_weight) estimator.set_average_normal_weight(*options.average_normal_weight);
  header.set_invalid_point_policy(options.skip_invalid ? v1::INVALID_POINT_POLICY_SKIP
                                                       : v1::INVALID_POINT_POLICY_REJECT);
  header.set_opposed_normals_policy(options.reject_opposed_normals ? v1::OPPOSED_NORMALS_POLICY_REJECT
                                                                   : v1::OPPOSED_NORMALS_POLICY_MARK);
  for (const std::string& name : options.quantities) header.add_quantities(*curvature::wire::QuantityOf(name));
  if (options.normals.source != NormalSource::kGiven) FillNormals(options.normals, *header.mutable_normals());
  if (!cloud.ids().empty()) header.mutable_part()->set_has_ids(true);
  if (!cloud.roles().empty()) header.mutable_part()->set_has_roles(true);
  if (options.lattice) {
    header.mutable_part()->mutable_lattice()->set_spacing(options.lattice->spacing);
    Set(options.lattice->origin, header.mutable_part()->mutable_lattice()->mutable_origin());
  }
  if (options.curvature_direction) Set(*options.curvature_direction, header.mutable_curvature_direction());
  header.set_request_tag(options.request_tag);
  header.set_priority(ToProto(options.priority));
  return grpc::Slice(request.SerializeAsString());
}

size_t BytesPerPoint(const CloudView& cloud) {
  return cloud.array_count() * cloud.point_bytes() + (cloud.ids().empty() ? 0 : sizeof(uint64_t)) +
         (cloud.roles().empty() ? 0 : 1);
}

grpc::Slice PackChunk(const CloudView& cloud, size_t first, size_t count) {
  const size_t offset = first * cloud.point_bytes(), bytes = count * cloud.point_bytes();
  char *positions = nullptr, *normals = nullptr, *viewpoints = nullptr, *directions = nullptr, *ids = nullptr;
  char* roles = nullptr;
  curvature::wire::BulkWriter writer(v1::EstimateCurvatureRequest::kChunkFieldNumber);
  writer.AddNumber(v1::PointChunk::kFirstIndexFieldNumber, first);
  writer.AddArray(v1::PointChunk::kPositionsFieldNumber, bytes, &positions);
  if (!cloud.normals().empty()) writer.AddArray(v1::PointChunk::kNormalsFieldNumber, bytes, &normals);
  if (!cloud.viewpoints().empty()) writer.AddArray(v1::PointChunk::kViewpointsFieldNumber, bytes, &viewpoints);
  if (!cloud.directions().empty()) {
    writer.AddArray(v1::PointChunk::kCurvatureDirectionsFieldNumber, bytes, &directions);
  }
  if (!cloud.ids().empty()) writer.AddArray(v1::PointChunk::kIdsFieldNumber, count * sizeof(uint64_t), &ids);
  if (!cloud.roles().empty()) writer.AddArray(v1::PointChunk::kRolesFieldNumber, count, &roles);
  return writer.Finish([&] {
    std::memcpy(positions, cloud.positions().data() + offset, bytes);
    if (normals != nullptr) std::memcpy(normals, cloud.normals().data() + offset, bytes);
    if (viewpoints != nullptr) std::memcpy(viewpoints, cloud.viewpoints().data() + offset, bytes);
    if (directions != nullptr) std::memcpy(directions, cloud.directions().data() + offset, bytes);
    if (ids != nullptr) std::memcpy(ids, cloud.ids().data() + first, count * sizeof(uint64_t));
    if (roles != nullptr) std::memcpy(roles, cloud.roles().data() + first, count);
  });
}

}  // namespace curv
