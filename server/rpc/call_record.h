// Holds what is known about a call when it is over, for its log line and the metrics.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "core/cloud/coarse_positions.h"
#include "core/estimators/curvature_field.h"
#include "core/estimators/seams/normals_agreement.h"
#include "core/normals/normals.h"
#include "core/normals/trust/surface_probe.h"
#include "core/scale/scale_report.h"
#include "server/rpc/rpc_method.h"

namespace curvd {

// Wall-clock seconds of each phase that the call came to; of the one in which it ended, until then.
struct PhaseTimes {
  std::optional<double> receive;  // header to half-close, without `admit`
  std::optional<double> admit;    // waiting for memory, which may be between two chunks
  std::optional<double> queue;    // waiting for a worker
  std::optional<double> index;
  std::optional<double> normals;      // making them
  std::optional<double> orientation;  // turning them
  std::optional<double> estimate;
  std::optional<double> send;  // first result to summary
};

// What comes with each point of a call, any of which may make the point unusable.
struct PointInput {
  bool has_normals = true;
  bool has_viewpoints = false;
  bool has_lattice = false;
  bool has_doubles = false;
};

struct CallRecord {
  RpcMethod method = RpcMethod::kEstimateCurvature;
  std::string request_id;
  std::string peer;
  std::string caller;  // who was let in; empty if nobody was
  std::string request_tag;
  absl::Status status;
  uint64_t points_received = 0;
  std::array<uint64_t, kPointStatusEnd> status_counts{};  // of a call that was estimated
  NormalsAgreement agreement;                             // likewise
  std::optional<NormalsOffSurface> off_surface;           // likewise, if it tells
  std::optional<NormalReport> normal_report;              // likewise, unless normals were taken as given
  std::optional<ScaleReport> scale_report;                // of an automatic estimate
  std::optional<CoarsePositions> coarse_positions;        // of a call whose points came
  std::optional<uint32_t> least_neighbor_count;           // that was asked for; none by radius
  PointInput point_input;
  uint64_t normals_rescaled = 0;
  uint64_t bytes_received = 0;
  uint64_t bytes_sent = 0;
  uint64_t peak_bytes = 0;
  double total_seconds = 0.0;
  PhaseTimes seconds;
};

}  // namespace curvd
