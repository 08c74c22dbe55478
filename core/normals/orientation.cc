#include "core/normals/orientation.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

namespace curvd {
namespace {

// Where less of the area is closed, winding numbers say nothing about the cloud.
constexpr double kMostlyClosed = 0.9;

}  // namespace

// What a phase runs; `end` adds what follows.
struct Orientation::Step {
  size_t blocks;
  std::function<absl::Status(const BlockContext&)> run;
  std::function<absl::Status()> end;
};

namespace {

template <typename Step>
class StepPhase final : public Phase {
 public:
  explicit StepPhase(Step step) : step_(std::move(step)) {}
  std::string_view name() const override { return kOrientationPhase; }
  absl::StatusOr<size_t> Begin() override { return step_.blocks; }
  absl::Status RunBlock(const BlockContext& context) override { return step_.run(context); }
  absl::Status End() override { return step_.end(); }

 private:
  const Step step_;
};

}  // namespace

Orientation::Orientation(SpatialIndex& index, const NormalOptions& options, const std::array<double, 3>& origin,
                         int thread_count, PhaseSink add_phase, std::function<absl::Status()> then)
    : index_(index),
      options_(options),
      origin_(origin),
      add_phase_(std::move(add_phase)),
      then_(std::move(then)),
      tree_(index),
      scratch_(static_cast<size_t>(thread_count)) {}

void Orientation::Add(Step step) { add_phase_(std::make_unique<StepPhase<Step>>(std::move(step))); }

void Orientation::Start() { std::holds_alternative<ConsistentSides>(options_.sides) ? AddLinks() : AddDirectTurns(); }

void Orientation::AddLinks() {
  // A phase of its own takes the memory, so that an error is the job's.
  Add({0, nullptr, [this] {
         if (absl::Status status = tree_.Start(); !status.ok()) return status;
         Add({chunk_count(), [this](const BlockContext& context) { return LinkBlock(context); },
              [this] {
                scratch_.clear();
                return AddRound();
              }});
         return absl::OkStatus();
       }});
}

absl::Status Orientation::LinkBlock(const BlockContext& context) {
  std::unique_ptr<WorkerScratch>& scratch = scratch_[static_cast<size_t>(context.worker)];
  if (scratch == nullptr) scratch = std::make_unique<WorkerScratch>();
  scratch->links.stopped = &context.stopped;
  // A block past the first ones is the rest of a chunk, from the place that its number tells.
  const bool is_rest = context.block >= chunk_count();
  const size_t first = is_rest ? context.block - chunk_count() : context.block * SideTree::kChunkPoints;
  const absl::StatusOr<size_t> rest = tree_.Link(first, scratch->links, scratch->forest);
  if (!rest.ok()) return rest.status();
  if (*rest != SideTree::kNoRest) context.add_block(chunk_count() + *rest);
  return absl::OkStatus();
}

bool Orientation::all_closed() const {
  const auto* consistent = std::get_if<ConsistentSides>(&options_.sides);
  return consistent != nullptr && consistent->closed;
}

absl::Status Orientation::AddRound() {
  if (!tree_.HasLinks()) return AddPieces();
  const auto each_chunk = [this](void (SideTree::*run)(size_t), std::function<absl::Status()> end) {
    Add({chunk_count(),
         [this, run](const BlockContext& context) {
           (tree_.*run)(context.block);
           return absl::OkStatus();
         },
         std::move(end)});
  };
  const auto nothing = [] { return absl::OkStatus(); };
  each_chunk(&SideTree::Propose, nothing);
  each_chunk(&SideTree::Follow, nothing);
  each_chunk(&SideTree::Flatten, [this] { return AddRound(); });
  return absl::OkStatus();
}

absl::Status Orientation::AddPieces() {
  piece_count_ = tree_.NumberPieces();
  sides_.emplace(index_, tree_);
  Add({chunk_count(),
       [this](const BlockContext& context) {
         sides_->SumChunk(context.block);
         return absl::OkStatus();
       },
       [this] {
         sides_->Finish(piece_count_, {options_.source == NormalSource::kOrient, all_closed()});
         double area = 0.0, closed = 0.0;
         for (const PieceSums& piece : sides_->pieces()) {
           area += piece.area;
           if (!IsClosed(piece) && !all_closed()) continue;
           ++closed_count_;
           closed += piece.area;
         }
         closed_share_ = area > 0.0 ? closed / area : 0.0;
         AddTurns();
         return absl::OkStatus();
       }});
  return absl::OkStatus();
}

void Orientation::AddTurns() {
  Add({chunk_count(),
       [this](const BlockContext& context) {
         TurnPieces(context.block);
         return absl::OkStatus();
       },
       [this] { return closed_share_ >= kMostlyClosed || all_closed() ? AddCertificate() : Finish(); }});
}

template <typename IsTurned>
void Orientation::TurnChunk(size_t chunk, const IsTurned& is_turned) {
  const size_t first = chunk * SideTree::kChunkPoints;
  const size_t last = std::min(first + SideTree::kChunkPoints, index_.point_count());
  size_t turned = 0;
  for (size_t place = first; place < last; ++place) {
    if (!is_turned(place)) continue;
    SpatialIndex::LeafNormals& normals = index_.mutable_normals(place / SpatialIndex::kLeafSize);
    const size_t lane = place % SpatialIndex::kLeafSize;
    normals.x[lane] = -normals.x[lane];
    normals.y[lane] = -normals.y[lane];
    normals.z[lane] = -normals.z[lane];
    ++turned;
  }
  flipped_ += turned;
}

void Orientation::TurnPieces(size_t chunk) {
  TurnChunk(chunk, [this](size_t place) {
    const uint32_t piece = tree_.piece(place);
    return piece != SideTree::kNoPiece && tree_.is_opposite(place) != sides_->is_turned(piece);
  });
}

absl::Status Orientation::AddCertificate() {
  winding_.emplace(index_, tree_);
  if (absl::Status status = winding_->Start(); !status.ok()) return status;
  Add({chunk_count(),
       [this](const BlockContext& context) {
         winding_->SumChunk(context.block);
         return absl::OkStatus();
       },
       [this] {
         winding_->SumNodes();
         AddSamples();
         return absl::OkStatus();
       }});
  return absl::OkStatus();
}

void Orientation::AddSamples() {
  Add({winding_->block_count(),
       [this](const BlockContext& context) {
         winding_->Sample(context.block, context.stopped);
         return absl::OkStatus();
       },
       [this] {
         certificate_ = winding_->value();
         return Finish();
       }});
}

void Orientation::AddDirectTurns() {
  Add({chunk_count(),
       [this](const BlockContext& context) {
         TurnDirectly(context.block);
         return absl::OkStatus();
       },
       [this] { return Finish(); }});
}

void Orientation::TurnDirectly(size_t chunk) {
  const auto* one = std::get_if<SidesTowardViewpoint>(&options_.sides);
  const auto* each = std::get_if<SidesTowardViewpoints>(&options_.sides);
  const auto* along = std::get_if<SidesAlongDirection>(&options_.sides);
  const int to_input = -index_.scale_exponent();
  TurnChunk(chunk, [&](size_t place) {
    const size_t leaf = place / SpatialIndex::kLeafSize, lane = place % SpatialIndex::kLeafSize;
    const SpatialIndex::LeafPositions& p = index_.positions(leaf);
    const SpatialIndex::LeafNormals& n = index_.normals(leaf);
    const float position[3] = {p.x[lane], p.y[lane], p.z[lane]};
    const float normal[3] = {n.x[lane], n.y[lane], n.z[lane]};
    double toward = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
      // In the order of input, which is that of ranks.
      const double from = one != nullptr    ? one->viewpoint[axis]
                          : each != nullptr ? each->viewpoints[p.id[lane]][axis]
                                            : 0;
      const double here = std::ldexp(static_cast<double>(position[axis]), to_input) + origin_[axis];
      toward += normal[axis] * (along != nullptr ? along->direction[axis] : from - here);
    }
    return toward < 0.0;
  });
}

absl::Status Orientation::Finish() {
  winding_.reset();
  sides_.reset();
  tree_.Clear();
  return then_();
}

void Orientation::Report(NormalReport& report) const {
  report.flipped_count = flipped_;
  report.piece_count = piece_count_;
  report.closed_piece_count = closed_count_;
  report.closed_area_share = closed_share_;
  report.repaired_count = repaired_count_;
  report.certificate = certificate_;
}

size_t Orientation::bytes() const {
  return tree_.bytes() + (sides_.has_value() ? sides_->bytes() : 0) + (winding_.has_value() ? winding_->bytes() : 0);
}

size_t Orientation::BytesPerPoint(const NormalOptions& options) {
  // Of the tree 8 bytes for the cheapest link, 4 each for parent and piece, 2 for the area, and 1.2 links a point.
  constexpr size_t kTree = 33;
  return options.source != NormalSource::kGiven && std::holds_alternative<ConsistentSides>(options.sides) ? kTree : 0;
}

size_t Orientation::ScratchBytes(const NormalOptions& options, size_t point_count) {
  return BytesPerPoint(options) == 0 ? 0 : SideTree::ScratchBytes(point_count);
}

}  // namespace curvd
