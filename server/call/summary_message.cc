#include "server/call/summary_message.h"

#include <algorithm>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "core/estimators/options.h"
#include "server/call/scale/wire_scale.h"
#include "server/call/wire_normals.h"

namespace curvd {
namespace {

// "12,345".
std::string WithSeparators(uint64_t number) {
  std::string digits = absl::StrCat(number);
  for (size_t at = digits.size(); at > 3;) digits.insert(at -= 3, 1, ',');
  return digits;
}

// "1 patch", "12,345 patches".
std::string Counted(uint64_t number, absl::string_view thing) {
  const char* plural = number == 1 ? "" : absl::EndsWith(thing, "ch") ? "es" : "s";
  return absl::StrCat(WithSeparators(number), " ", thing, plural);
}

// What to do where normals contradict each other, which depends on who made them.
const char* RemedyFor(const CallRecord& record) {
  if (!record.normal_report.has_value()) {
    return record.agreement.flipped_patches > 0
               ? "make all normals point to one side, outward on closed surfaces, and estimate again"
               : "make all normals point to one side, outward on closed surfaces, and estimate again; if they do, the "
                 "surface has a crease or a rim there, across which its normals were made";
  }
  // Only consistent sides have pieces.
  if (record.normal_report->piece_count == 0) {
    return "the surface there may turn away from the viewpoint or direction that normals were turned to, as walls do "
           "from a direction up; orient them consistently";
  }
  return record.normal_report->method.has_value()
             ? "the points there may be no surface, as in trees; or their normals need more neighbors"
             : "the points there may be no surface, as in trees; or their normals are wrong: have them estimated";
}

// What a person should know whose normals contradict each other.
std::string OpposedNormalsText(uint64_t points, const CallRecord& record) {
  const double share = static_cast<double>(record.agreement.opposed_pairs) /
                       static_cast<double>(std::max<uint64_t>(record.agreement.near_pairs, 1));
  return absl::StrFormat(
      "normals point to opposite sides of one surface around %s of %s, which therefore have no curvature "
      "(opposed_normals); %.2g %% of the pairs of nearest neighbors are opposed, %s flipped. Elsewhere the sign of "
      "curvature may be wrong: %s",
      WithSeparators(points), Counted(record.points_received, "point"), 100.0 * share,
      Counted(record.agreement.flipped_patches, "patch"), RemedyFor(record));
}

// What a person should know whose normals the server could not orient.
std::string DoubtfulOrientationText(const NormalReport& report) {
  if (report.ambiguous_piece_count > 0) {
    return absl::StrFormat(
        "some of the oriented normals may point to the wrong side: %s within others, and nothing tells whether "
        "such a piece bounds a hollow there or is a body of its own, as which its normals point outward; the sign of "
        "curvature is as doubtful. Send such pieces in calls of their own, or say where they were seen from",
        absl::StrCat(Counted(report.ambiguous_piece_count, "closed piece"),
                     report.ambiguous_piece_count == 1 ? " lies" : " lie"));
  }
  if (report.mixes_sides) {
    return absl::StrFormat(
        "some of the oriented normals may point to the wrong side: %.2g %% of the neighbors of which they were made "
        "point to the other side, and the sign of curvature is as doubtful. That happens where parts are thinner than "
        "neighborhoods are wide. Send more points, ask for fewer neighbors, or say where they were seen from",
        100.0 * report.opposed_share.value_or(0.0));
  }
  if (report.torn_share.value_or(0.0) > kMostTornShare) {
    return absl::StrFormat(
        "some of the oriented normals point to the wrong side: those of %.2g %% of the neighbors on one sheet are "
        "opposed, and the sign of curvature is as doubtful. That happens where the points are too few for how the "
        "surface bends. Send more points, or say where they were seen from",
        100.0 * *report.torn_share);
  }
  if (report.may_be_closed) {
    return "the oriented normals may point to the wrong side: the points lie on both sides of an open sheet, and not "
           "as noise would have them, so that they may be the two sides of a thin body; the sign of curvature is as "
           "doubtful. Send more points, or say where they were seen from";
  }
  if (report.turned_share.value_or(0.0) > report.most_turned_share) {
    return absl::StrFormat(
        "some of the oriented normals point to the wrong side: made of another number of neighbors, %.2g %% of them "
        "point to the other side, and the sign of curvature is as doubtful. That happens where positions are too noisy "
        "for the shape, or too few for how thin it is. Send more points or less noisy ones, or say where they were "
        "seen from",
        100.0 * *report.turned_share);
  }
  return absl::StrFormat(
      "some of the oriented normals point to the wrong side: their certificate is %.2g, at most %.2g can be trusted, "
      "and the sign of curvature is as doubtful. That happens where two sheets are as near to each other as points of "
      "one sheet are. Send more points, or say where they were seen from",
      *report.certificate, report.max_trusted_certificate);
}

void AddCoarsePositionsWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  if (!record.coarse_positions.has_value()) return;
  const CoarsePositions& coarse = *record.coarse_positions;
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_COARSE_POSITIONS);
  warning->set_message(absl::StrFormat(
      "positions are floats near %.3g, which lie %.2g apart there, and the points about %.2g: the results are those of "
      "the rounding. Send doubles, or subtract an origin before the coordinates become floats",
      coarse.farthest, coarse.step, coarse.spacing));
}

void AddOffSurfaceWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  if (!record.off_surface.has_value() || record.off_surface->share() < kMostOffSurface) return;
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_NORMALS_OFF_SURFACE);
  warning->set_message(absl::StrFormat(
      "the normals do not fit the positions: at %.0f %% of %s that were looked at they are more than 30 degrees off "
      "the plane of the neighbors, so that curvature means little. That happens where positions were turned or "
      "mirrored without their normals, where normals are placeholders, have noise of 20 degrees or more, or were made "
      "of neighbors on one scan line, and where the points are too few for how the surface bends. Send more points, or "
      "have the normals estimated",
      100.0 * record.off_surface->share(), Counted(record.off_surface->sampled_points, "point")));
}

void AddOrientationWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  if (!record.normal_report.has_value() || !record.normal_report->is_doubtful()) return;
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_DOUBTFUL_ORIENTATION);
  warning->set_message(DoubtfulOrientationText(*record.normal_report));
}

void AddSeamWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  if (record.agreement.seam_points == 0) return;
  const uint64_t points = record.status_counts[static_cast<size_t>(PointStatus::kOpposedNormals)];
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_OPPOSED_NORMALS);
  warning->set_message(OpposedNormalsText(points, record));
  warning->set_point_count(points);
  warning->set_pair_count(record.agreement.near_pairs);
  warning->set_opposed_pair_count(record.agreement.opposed_pairs);
  warning->set_flipped_patch_count(record.agreement.flipped_patches);
}

// What a person should know whose points were left out of all neighborhoods.
std::string OutliersText(uint64_t outliers, uint64_t points) {
  if (outliers == 1) {
    return absl::StrCat("1 of ", Counted(points, "point"),
                        " lies off the surface around it, or has a normal that points away from those of all its "
                        "neighbors (outlier), and was left out; if it belongs to the surface, choose the number of "
                        "neighbors yourself");
  }
  return absl::StrCat(WithSeparators(outliers), " of ", Counted(points, "point"),
                      " lie off the surface around them, or have normals that point away from those of all their "
                      "neighbors (outlier), and were left out; if they belong to the surface, choose the number of "
                      "neighbors yourself");
}

void AddOutliersWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  const uint64_t outliers = record.status_counts[static_cast<size_t>(PointStatus::kOutlier)];
  if (outliers == 0) return;
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_OUTLIERS);
  warning->set_message(OutliersText(outliers, record.points_received));
  warning->set_point_count(outliers);
}

// What may be wrong with points that cannot be used.
std::string UnusableText(const PointInput& input) {
  std::string text = "their positions are not finite";
  if (input.has_doubles) text += ", or lie farther than 3e38, the largest float, from the others";
  if (input.has_lattice) text += ", or lie farther than 2^23 times lattice.spacing from lattice.origin";
  if (input.has_viewpoints) text += ", or their viewpoints are not finite";
  if (input.has_normals) text += ", or their normals have no direction";
  return text;
}

// What most points of a cloud without results lack, and what to do.
std::string LackText(PointStatus status, const CallRecord& record) {
  switch (status) {
    case PointStatus::kTooFewNeighbors:
      if (record.least_neighbor_count.value_or(0) > record.points_received) {
        return absl::StrFormat(
            "neighborhoods of %s or more were asked for, and the cloud has %s: send more points, or ask for fewer "
            "neighbors",
            Counted(*record.least_neighbor_count, "point"), WithSeparators(record.points_received));
      }
      if (record.points_received < kMinNeighborCount) {
        return absl::StrFormat("each needs %u points or more, and the cloud has %u: send more points",
                               kMinNeighborCount, record.points_received);
      }
      return "too few points that can be used lie within reach: ask for a larger radius, or for fewer neighbors";
    case PointStatus::kDegenerateArea:
      return "neighborhoods have no area, as where points lie on one line or in one place, or so far from zero that "
             "floats do not tell them apart: subtract an origin then, or send doubles; or they are so small that "
             "curvature is beyond 3e38, the largest float: choose a smaller unit of length";
    case PointStatus::kInvalidInput:
      return UnusableText(record.point_input);
    case PointStatus::kInconsistentNormals:
      return "normals cancel out within neighborhoods: make them point to one side, or ask for fewer neighbors";
    default:
      return "neighborhoods fit no surface: the points may lie on one line, or need more neighbors";
  }
}

void AddNoResultsWarning(const CallRecord& record, curvature::v1::Summary* summary) {
  const auto& counts = record.status_counts;
  const auto most = std::max_element(counts.begin(), counts.end());
  const auto status = static_cast<PointStatus>(most - counts.begin());
  // These have warnings of their own.
  const bool is_told = status == PointStatus::kOpposedNormals || status == PointStatus::kOutlier;
  if (*most == 0 || counts[static_cast<size_t>(PointStatus::kOk)] > 0 || is_told) return;
  curvature::v1::Warning* warning = summary->add_warnings();
  warning->set_code(curvature::v1::WARNING_CODE_NO_RESULTS);
  warning->set_message(
      absl::StrFormat("no point has a result; most are %s: %s", PointStatusName(status), LackText(status, record)));
}

}  // namespace

void FillSummary(const CallRecord& record, curvature::v1::Summary* summary) {
  summary->set_point_count(record.points_received);
  summary->set_normals_rescaled(record.normals_rescaled);
  summary->set_peak_bytes(record.peak_bytes);

  const auto count = [&record](PointStatus status) { return record.status_counts[static_cast<size_t>(status)]; };
  curvature::v1::StatusCounts* counts = summary->mutable_status_counts();
  counts->set_ok(count(PointStatus::kOk));
  counts->set_too_few_neighbors(count(PointStatus::kTooFewNeighbors));
  counts->set_degenerate_area(count(PointStatus::kDegenerateArea));
  counts->set_invalid_input(count(PointStatus::kInvalidInput));
  counts->set_inconsistent_normals(count(PointStatus::kInconsistentNormals));
  counts->set_singular_fit(count(PointStatus::kSingularFit));
  counts->set_opposed_normals(count(PointStatus::kOpposedNormals));
  counts->set_outlier(count(PointStatus::kOutlier));

  curvature::v1::PhaseSeconds* seconds = summary->mutable_seconds();
  seconds->set_receive(record.seconds.receive.value_or(0.0));
  seconds->set_queue(record.seconds.queue.value_or(0.0));
  seconds->set_index(record.seconds.index.value_or(0.0));
  seconds->set_normals(record.seconds.normals.value_or(0.0));
  seconds->set_orientation(record.seconds.orientation.value_or(0.0));
  seconds->set_estimate(record.seconds.estimate.value_or(0.0));
  seconds->set_send(record.seconds.send.value_or(0.0));
  AddCoarsePositionsWarning(record, summary);
  AddOffSurfaceWarning(record, summary);
  AddSeamWarning(record, summary);
  AddOutliersWarning(record, summary);
  AddOrientationWarning(record, summary);
  AddNoResultsWarning(record, summary);
  if (record.normal_report.has_value()) WriteReport(*record.normal_report, *summary->mutable_normals());
  if (record.scale_report.has_value()) WriteReport(*record.scale_report, *summary->mutable_scale());
}

}  // namespace curvd
