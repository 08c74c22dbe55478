// Turns the normals of an index so that they point to one side of the surface: the phases that do it.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/phase.h"
#include "core/index/spatial_index.h"
#include "core/normals/normal_options.h"
#include "core/normals/normals.h"
#include "core/normals/orientation/hollow_walls.h"
#include "core/normals/orientation/piece_sides.h"
#include "core/normals/orientation/side_repair.h"
#include "core/normals/orientation/side_tree.h"
#include "core/normals/orientation/winding_field.h"

namespace curvd {

// Where the phases of a job are put: at the end of its list (PhasedJob::AddPhase).
using PhaseSink = std::function<void(std::unique_ptr<Phase>)>;

// The name of all phases that orient.
inline constexpr std::string_view kOrientationPhase = "orientation";

// What is known of a cloud before its normals are oriented.
struct OrientationHints {
  bool two_sheets = false;  // pieces that look open may be thin closed ones: each large piece gets a certificate
  size_t links_per_point = kLinksPerPoint;  // as SideTree has it
  // Whether clusters are turned against the links between them where they then fit a closed surface (SideRepair).
  bool may_repair = true;
};

// Orients the normals of one index by phases, each of which adds what follows it. The result depends on the index and
// the options alone: not on threads.
class Orientation {
 public:
  // `origin`: what was subtracted from the input's positions (Cloud::origin). `then` is called once all normals point
  // where they should; it adds the phases that follow. REQUIRES: index.has_normals(); NaN where a point has none;
  // `index`, what `options` refers to, and the orientation outlive the phases.
  Orientation(SpatialIndex& index, const NormalOptions& options, const std::array<double, 3>& origin, int thread_count,
              PhaseSink add_phase, std::function<absl::Status()> then, const OrientationHints& hints);

  // Adds the first phase.
  void Start();

  // Adds to the report what was found. REQUIRES: `then` was called.
  void Report(NormalReport& report) const;

  // Bytes held now, but for the workers' scratch; none once `then` is called.
  size_t bytes() const;
  // Bytes a point that the phases allocate: links, the tree, and areas.
  static size_t BytesPerPoint(const NormalOptions& options);
  // Bytes that the scratch of one worker holds at most.
  static size_t ScratchBytes(const NormalOptions& options, size_t point_count);
  // Bytes of the winding numbers at most, once the workers' scratch is gone.
  static size_t FieldBytes(const NormalOptions& options, size_t point_count);

 private:
  struct Step;
  struct WorkerScratch {
    LinkScratch links;
    ForestScratch forest;
  };

  void Add(Step step);
  // The steps, each of which is a phase that adds the next one.
  void AddLinks();
  absl::Status AddRound();
  absl::Status AddPieces();
  void AddField();
  void AddSamples();
  void AddDescents(size_t first, size_t last);
  void TakeRepairs();
  void AddWalls();
  void TakeWalls();
  void AddTurns();
  void AddDirectTurns();
  // Gives memory back, and goes on.
  absl::Status Finish();

  absl::Status LinkBlock(const BlockContext& context);
  // Turns the normals of a chunk where is_turned(place) says so.
  template <typename IsTurned>
  void TurnChunk(size_t chunk, const IsTurned& is_turned);
  void TurnPieces(size_t chunk);
  void TurnDirectly(size_t chunk);
  size_t chunk_count() const { return tree_.chunk_count(); }
  bool all_closed() const;
  bool IsPieceClosed(size_t piece) const { return piece_is_closed_[piece] != 0; }

  SpatialIndex& index_;
  const NormalOptions& options_;
  const std::array<double, 3> origin_;
  const PhaseSink add_phase_;
  const std::function<absl::Status()> then_;
  const OrientationHints hints_;
  SideTree tree_;
  std::optional<PieceSides> sides_;
  std::optional<WindingField> field_;
  std::vector<SideRepair> repairs_;       // of the field's pieces
  std::vector<uint8_t> piece_is_closed_;  // by piece
  std::optional<HollowWalls> walls_;
  std::vector<std::unique_ptr<WorkerScratch>> scratch_;
  std::atomic<size_t> flipped_ = 0;
  size_t piece_count_ = 0, closed_count_ = 0;
  double closed_share_ = 0.0;
  size_t repaired_count_ = 0, inner_wall_count_ = 0, ambiguous_piece_count_ = 0;
  std::optional<double> certificate_;
};

}  // namespace curvd
