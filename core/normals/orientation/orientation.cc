#include "core/normals/orientation/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/function_phase.h"

namespace curvd {

// What a phase runs; `end` adds what follows.
struct Orientation::Step {
  size_t blocks;
  std::function<absl::Status(const BlockContext&)> run;
  std::function<absl::Status()> end;
};

Orientation::Orientation(SpatialIndex& index, const NormalOptions& options, const std::array<double, 3>& origin,
                         int thread_count, PhaseSink add_phase, std::function<absl::Status()> then,
                         const OrientationHints& hints)
    : index_(index),
      options_(options),
      origin_(origin),
      add_phase_(std::move(add_phase)),
      then_(std::move(then)),
      hints_(hints),
      tree_(index, hints.links_per_point),
      scratch_(static_cast<size_t>(thread_count)) {}

void Orientation::Add(Step step) {
  const auto begin = [blocks = step.blocks] { return blocks; };
  add_phase_(std::make_unique<FunctionPhase>(kOrientationPhase,
                                             PhaseFunctions{begin, std::move(step.run), std::move(step.end)}));
}

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
  const bool is_round = tree_.BeginRound();
  const auto each_chunk = [this](void (SideTree::*run)(size_t), std::function<absl::Status()> end) {
    Add({chunk_count(),
         [this, run](const BlockContext& context) {
           (tree_.*run)(context.block);
           return absl::OkStatus();
         },
         std::move(end)});
  };
  const auto nothing = [] { return absl::OkStatus(); };
  if (!is_round) {
    each_chunk(&SideTree::FlattenPlaces, [this] { return AddPieces(); });
    return absl::OkStatus();
  }
  each_chunk(&SideTree::Propose, nothing);
  each_chunk(&SideTree::Follow, nothing);
  each_chunk(&SideTree::Flatten, nothing);
  each_chunk(&SideTree::EndRound, [this] { return AddRound(); });
  return absl::OkStatus();
}

absl::Status Orientation::AddPieces() {
  tree_.JoinClusters();
  sides_.emplace(index_, tree_);
  Add({chunk_count(),
       [this](const BlockContext& context) {
         sides_->SumChunk(context.block);
         return absl::OkStatus();
       },
       [this] {
         sides_->Finish({options_.source == NormalSource::kOrient, all_closed()});
         AddField();
         return absl::OkStatus();
       }});
  return absl::OkStatus();
}

// The winding numbers of those pieces that they say something about: closed ones, those that may be, and those whose
// clusters may have got the wrong sides, as far as they are large.
void Orientation::AddField() {
  const std::vector<PieceSums>& pieces = sides_->pieces();
  std::vector<uint32_t> cluster_counts(pieces.size()), wanted;
  for (const Cluster& cluster : tree_.clusters()) ++cluster_counts[cluster.piece];
  for (size_t i = 0; i < pieces.size(); ++i) {
    piece_is_closed_.push_back(IsClosed(pieces[i]) || (all_closed() && pieces[i].area > 0.0) ? 1 : 0);
    const bool is_large = pieces[i].points >= tree_.least_points();
    const bool tells = IsPieceClosed(i) || cluster_counts[i] > 1 || hints_.two_sheets;
    if (is_large && tells) wanted.push_back(static_cast<uint32_t>(i));
  }
  if (wanted.empty()) return AddTurns();
  field_.emplace(index_, tree_, wanted);
  Add({chunk_count(),
       [this](const BlockContext& context) {
         field_->SumChunk(context.block);
         return absl::OkStatus();
       },
       [this] {
         field_->Finish();
         AddSamples();
         return absl::OkStatus();
       }});
}

void Orientation::AddSamples() {
  Add({field_->block_count(),
       [this](const BlockContext& context) {
         field_->Sample(context.block, context.stopped);
         return absl::OkStatus();
       },
       [this] {
         for (const FieldPiece& piece : field_->pieces()) {
           std::vector<uint8_t> turned;
           for (const uint32_t cluster : piece.clusters) turned.push_back(sides_->is_turned(cluster) ? 1 : 0);
           repairs_.emplace_back(piece, std::move(turned), !all_closed());
         }
         AddDescents(0, 1);
         return absl::OkStatus();
       }});
}

// First one descent for each piece; then all others, where the first one finds something.
void Orientation::AddDescents(size_t first, size_t last) {
  std::vector<size_t> wanted;
  for (size_t i = 0; i < repairs_.size(); ++i) {
    const bool is_promising = first == 0 || IsPieceClosed(field_->pieces()[i].piece) || repairs_[i].IsPromising();
    if (repairs_[i].IsWanted() && is_promising) wanted.push_back(i);
  }
  const size_t starts = last - first;
  Add({wanted.size() * starts,
       [this, wanted, first, starts](const BlockContext& context) {
         if (!context.stopped) repairs_[wanted[context.block / starts]].Descend(first + context.block % starts);
         return absl::OkStatus();
       },
       [this, first] {
         if (first == 0) {
           AddDescents(1, SideRepair::kStarts);
         } else {
           TakeRepairs();
           AddWalls();
         }
         return absl::OkStatus();
       }});
}

void Orientation::TakeRepairs() {
  constexpr size_t kLeastSamples = 64;  // for a certificate that means something
  for (size_t i = 0; i < repairs_.size(); ++i) {
    const FieldPiece& field = field_->pieces()[i];
    uint8_t& is_closed = piece_is_closed_[field.piece];
    // Sides that fit a closed surface much better, but not well enough to be taken; or a thin part that looks open.
    const bool is_doubtful = hints_.two_sheets || (is_closed == 0 && repairs_[i].IsPromising());
    if (hints_.may_repair && repairs_[i].Accept()) {
      is_closed = 1;
      for (size_t c = 0; c < field.clusters.size(); ++c) {
        const uint32_t cluster = field.clusters[c];
        if ((repairs_[i].turned()[c] != 0) == sides_->is_turned(cluster)) continue;
        sides_->Turn(cluster);
        repaired_count_ += tree_.clusters()[cluster].points;
      }
    }
    if ((is_closed == 0 && !is_doubtful) || field.samples.size() < kLeastSamples) continue;
    certificate_ = std::max(certificate_.value_or(0.0), repairs_[i].certificate());
  }
}

// Pieces whose sides the repair chose are left out: their sums are of other sides.
void Orientation::AddWalls() {
  const std::vector<PieceSums>& pieces = sides_->pieces();
  std::vector<uint8_t> is_candidate;
  is_candidate.reserve(pieces.size());
  for (const PieceSums& piece : pieces) {
    is_candidate.push_back(piece.points >= tree_.least_points() && IsClosed(piece) ? 1 : 0);
  }
  for (size_t i = 0; i < repairs_.size(); ++i) {
    if (repairs_[i].is_accepted()) is_candidate[field_->pieces()[i].piece] = 0;
  }
  repairs_.clear();
  field_.reset();
  walls_.emplace(index_, tree_, *sides_, is_candidate);
  if (walls_->pair_count() == 0) return AddTurns();
  Add({chunk_count(),
       [this](const BlockContext& context) {
         walls_->SumChunk(context.block);
         return absl::OkStatus();
       },
       [this] {
         walls_->GroupSamples();
         return absl::OkStatus();
       }});
  Add({walls_->pair_count(),
       [this](const BlockContext& context) {
         if (!context.stopped) walls_->CheckPair(context.block);
         return absl::OkStatus();
       },
       [this] {
         TakeWalls();
         AddTurns();
         return absl::OkStatus();
       }});
}

void Orientation::TakeWalls() {
  const std::vector<uint32_t> inner = walls_->InnerPieces();
  inner_wall_count_ = inner.size();
  ambiguous_piece_count_ = walls_->AmbiguousCount();
  for (uint32_t cluster = 0; cluster < tree_.clusters().size(); ++cluster) {
    if (std::binary_search(inner.begin(), inner.end(), tree_.clusters()[cluster].piece)) sides_->Turn(cluster);
  }
}

void Orientation::AddTurns() {
  const std::vector<PieceSums>& pieces = sides_->pieces();
  double area = 0.0, closed = 0.0;
  for (size_t i = 0; i < pieces.size(); ++i) {
    area += pieces[i].area;
    if (!IsPieceClosed(i)) continue;
    ++closed_count_;
    closed += pieces[i].area;
  }
  piece_count_ = pieces.size();
  closed_share_ = area > 0.0 ? closed / area : 0.0;
  walls_.reset();
  Add({chunk_count(),
       [this](const BlockContext& context) {
         TurnPieces(context.block);
         return absl::OkStatus();
       },
       [this] { return Finish(); }});
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
    const uint32_t cluster = tree_.cluster(place);
    return cluster != SideTree::kNoCluster && tree_.is_opposite(place) != sides_->is_turned(cluster);
  });
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
  // Of a length at which no product is lost to underflow.
  std::array<double, 3> direction{};
  if (along != nullptr) {
    const auto& d = along->direction;
    const int exponent = std::ilogb(std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}));
    for (size_t axis = 0; axis < 3; ++axis) direction[axis] = std::ldexp(d[axis], -exponent);
  }
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
                          : each != nullptr ? each->viewpoints[index_.point_set().place_of(p.id[lane])][axis]
                                            : 0;
      const double here = std::ldexp(static_cast<double>(position[axis]), to_input) + origin_[axis];
      toward += normal[axis] * (along != nullptr ? direction[axis] : from - here);
    }
    return toward < 0.0;
  });
}

absl::Status Orientation::Finish() {
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
  report.inner_wall_count = inner_wall_count_;
  report.ambiguous_piece_count = ambiguous_piece_count_;
  report.certificate = certificate_;
}

size_t Orientation::bytes() const {
  return tree_.bytes() + (sides_.has_value() ? sides_->bytes() : 0) + (field_.has_value() ? field_->bytes() : 0) +
         (walls_.has_value() ? walls_->bytes() : 0);
}

size_t Orientation::BytesPerPoint(const NormalOptions& options) {
  // Of the tree 8 bytes for the cheapest link, 4 each for parent and cluster, 2 for the area, and 1.2 links a point.
  constexpr size_t kTree = 33;
  return options.source != NormalSource::kGiven && std::holds_alternative<ConsistentSides>(options.sides) ? kTree : 0;
}

size_t Orientation::ScratchBytes(const NormalOptions& options, size_t point_count) {
  return BytesPerPoint(options) == 0 ? 0 : SideTree::ScratchBytes(point_count);
}

size_t Orientation::FieldBytes(const NormalOptions& options, size_t point_count) {
  return BytesPerPoint(options) == 0
             ? 0
             : std::max(WindingField::MostBytes(point_count), HollowWalls::MostBytes(point_count));
}

}  // namespace curvd
