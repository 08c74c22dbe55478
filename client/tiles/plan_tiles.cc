#include "client/tiles/plan_tiles.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "absl/random/random.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/io/atomic_file.h"
#include "client/tiles/cells/cell_finder.h"
#include "client/tiles/input_points.h"
#include "client/tiles/lattice.h"
#include "client/tiles/sample.h"
#include "client/tiles/spill_file.h"

namespace curv {
namespace {

constexpr uint64_t kSampledInCell = 16;  // a cell is then right to a quarter
constexpr uint64_t kEnoughInCell = 64;   // and to an eighth; more only takes time
constexpr uint64_t kCellsInTile = 256;   // so that a halo of 4 % does not read much more than it keeps
constexpr uint64_t kLeastInCell = 64;    // points
constexpr size_t kLatticeSample = 16'384;
constexpr size_t kMostBuckets = 1024;
// What a point takes while a bucket is sorted: itself as it was read, with its cell, and as it is written.
constexpr uint64_t kSortedBytes = 128;

// The server's limit for distances (core/cloud/cloud.h).
constexpr double kMostCoordinate = 3e38;

bool IsFinite(const Position& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

bool IsWithinLimit(const Position& p) {
  return std::all_of(p.begin(), p.end(), [](double c) { return std::abs(c) <= kMostCoordinate; });
}

// What is wrong with a point that is not usable.
const char* FaultOf(const Position& p) {
  if (!IsFinite(p)) return " has a position that is not finite";
  return IsWithinLimit(p) ? " has a normal without a direction" : " has a coordinate beyond 3e38";
}

// What the server would not give the status of invalid input.
bool IsUsable(const TilePoint& point) {
  const std::array<float, 3>& n = point.normal;
  const bool has_direction =
      std::isfinite(n[0]) && std::isfinite(n[1]) && std::isfinite(n[2]) && (n[0] != 0 || n[1] != 0 || n[2] != 0);
  return IsWithinLimit(point.position) && has_direction;
}

std::string NewPlanId() {
  absl::BitGen bits;
  return absl::StrFormat("%016x", absl::Uniform<uint64_t>(bits));
}

// One plan in the making.
class Planner {
 public:
  Planner(const PlanRequest& request, std::stop_token stop,
          const std::function<void(const PlanProgress& progress)>& progress)
      : request_(request), stop_(std::move(stop)), progress_(progress), sample_(SampleSize()) {
    plan_.directory = request.directory;
    plan_.id = NewPlanId();
    plan_.memory_bytes = request.memory_bytes;
    plan_.tile_points = request.tile_points;
    plan_.reach = request.reach;
    plan_.options = request.options;
  }

  absl::StatusOr<PlanOutcome> Plan() {
    for (auto step : {&Planner::FindInputs, &Planner::MakeDirectory, &Planner::Look, &Planner::Divide,
                      &Planner::SortIntoBuckets, &Planner::WriteStore}) {
      if (absl::Status status = (this->*step)(); !status.ok()) return status;
    }
    if (absl::Status status = SavePlan(plan_); !status.ok()) return status;
    return PlanOutcome{std::move(plan_), std::move(notes_)};
  }

 private:
  uint64_t PointsInCell() const { return std::max(request_.tile_points / kCellsInTile, kLeastInCell); }
  // The cells take an eighth of the memory at most, and so do the sample, and the neighbors in it.
  uint64_t MostCells() const { return std::max<uint64_t>(request_.memory_bytes / 8 / (2 * sizeof(CellNode)), 16); }
  size_t SampleSize() const {
    const uint64_t most = request_.memory_bytes / 8 / (2 * (sizeof(Position) + sizeof(uint64_t)));
    return std::max<uint64_t>(std::min(most, kSampledInCell * MostCells()), kLatticeSample);
  }

  absl::Status FindInputs() {
    for (const std::string& path : request_.inputs) {
      std::error_code error;
      const std::filesystem::path absolute = std::filesystem::canonical(path, error);
      if (path == "-" || error) {
        return absl::InvalidArgumentError(path == "-"
                                              ? "standard input cannot be read twice: write it into a file first"
                                              : absl::StrCat("cannot read ", path, ": ", error.message()));
      }
      plan_.inputs.push_back({absolute.string(), request_.format, 0, {}});
    }
    return absl::OkStatus();
  }

  absl::Status MakeDirectory() {
    std::error_code error;
    if (std::filesystem::exists(plan_.PathOf("plan.json"), error)) {
      return absl::AlreadyExistsError(
          absl::StrCat(request_.directory,
                       " has a plan already: curv tiles run goes on with it; for a new one take another "
                       "directory, or remove this one"));
    }
    for (const char* name : {"", "results", "locks"}) {
      std::filesystem::create_directories(plan_.PathOf(name), error);
      if (error) {
        return absl::DataLossError(absl::StrCat("cannot make ", plan_.PathOf(name), ": ", error.message()));
      }
    }
    // Those of a plan that was removed or never finished.
    for (const auto& old : std::filesystem::directory_iterator(plan_.PathOf("results"), error)) {
      std::filesystem::remove(old.path(), error);
    }
    return absl::OkStatus();
  }

  // Reads all inputs once: counts, checks, draws a sample.
  absl::Status Look() {
    for (TileInput& input : plan_.inputs) {
      const absl::StatusOr<InputFile> file = InputFile::Open(input.path);
      if (!file.ok()) return file.status();
      input.stamp = file->stamp();
    }
    absl::Status status = ForEachBlock(plan_.inputs, Bounds(), [this](const PointBlock& block) {
      if (absl::Status step = Step("reading", block.first_id, 0); !step.ok()) return step;
      return LookAt(block);
    });
    if (!status.ok()) return status;
    for (const TileInput& input : plan_.inputs) {
      if (input.points == 0) return absl::InvalidArgumentError(absl::StrCat(input.path, ": the file holds no points"));
    }
    if (plan_.points > plan_.unusable) return absl::OkStatus();
    return absl::InvalidArgumentError("no point of the inputs has a finite position and a normal with a direction");
  }

  absl::Status LookAt(const PointBlock& block) {
    TileInput& input = plan_.inputs[block.input];
    if (absl::Status status = LookAtColumns(block); !status.ok()) return status;
    bool is_double = false;
    if (absl::Status status = ExtractPoints(block, points_, is_double); !status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(input.path, ": ", status.message()));
    }
    plan_.is_double = plan_.is_double || is_double;
    for (const TilePoint& point : points_) {
      if (IsUsable(point)) {
        sample_.Add(point.id, point.position);
      } else if (request_.skip_invalid) {
        ++plan_.unusable;
      } else {
        return absl::InvalidArgumentError(absl::StrCat(input.path, ": point ", input.points + point.id - block.first_id,
                                                       FaultOf(point.position),
                                                       ". With --on-invalid=skip such points get a status"));
      }
    }
    input.points += points_.size();
    plan_.points += points_.size();
    return absl::OkStatus();
  }

  // What is there in place of a column of another type. `in_order` has names and types.
  static std::string TypeHere(const std::string& name, const std::vector<std::string>& in_order) {
    for (const std::string& column : in_order) {
      if (column.starts_with(name + " "))
        return absl::StrCat("its column ", name, " is ", column.substr(name.size() + 1));
    }
    return absl::StrCat("it has no column ", name);
  }

  // The result has the columns that all blocks of all inputs have.
  absl::Status LookAtColumns(const PointBlock& block) {
    const TileInput& input = plan_.inputs[block.input];
    for (const std::string& note : block.table->notes) Note(absl::StrCat(input.path, ": ", note));
    std::set<std::string> here;
    std::vector<std::string> in_order;
    for (const Column& column : block.table->columns()) {
      in_order.push_back(ColumnText(column));
      here.insert(in_order.back());
    }
    if (block.first_id == 0) {
      plan_.columns = std::move(in_order);
      return absl::OkStatus();
    }
    for (const std::string& column : plan_.columns) {
      if (here.contains(column)) continue;
      const std::string name = column.substr(0, column.rfind(' '));
      if (name == "x" || name == "y" || name == "z" || name == "nx" || name == "ny" || name == "nz") {
        return absl::InvalidArgumentError(absl::StrCat(input.path, ": ", TypeHere(name, in_order), ", and ",
                                                       column.substr(name.size() + 1),
                                                       " in the inputs before it, which count as one cloud"));
      }
      if (input.points == 0) {
        Note(absl::StrCat("the result has no column ", column, ": ", input.path, " has none"));
      } else if (block.table->Find(name) != nullptr) {  // where it has none, the reader's note says why
        Note(absl::StrCat(input.path, ": left out column ", name, ": its values are not all of one kind"));
      }
    }
    std::erase_if(plan_.columns, [&](const std::string& column) { return !here.contains(column); });
    return absl::OkStatus();
  }

  void Note(std::string note) {
    if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) notes_.push_back(std::move(note));
  }

  absl::Status Divide() {
    const uint64_t wanted_cells = std::clamp<uint64_t>(Usable() / PointsInCell(), 1, MostCells());
    std::vector<Position> sample = sample_.Take(std::max<uint64_t>(kEnoughInCell * wanted_cells, kLatticeSample));
    if (plan_.is_double) {
      plan_.spacing = request_.spacing;
      if (plan_.spacing == 0.0) {
        plan_.spacing = LatticeSpacing(std::span(sample).first(std::min(sample.size(), kLatticeSample)), Usable());
      }
      if (plan_.spacing < kLeastSpacing || plan_.spacing > kMostSpacing) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "the lattice of the coordinates, which are doubles, is %g%s; it must be from 2^-100 to 2^100, about "
            "8e-31 to 1e30: choose another unit of length",
            plan_.spacing,
            request_.spacing == 0.0 ? ", at most 2^-12 of the distance between points" : " (--lattice)"));
      }
      for (Position& p : sample) p = OnLattice(p, plan_.spacing);
    }
    const uint64_t tiles = std::max<uint64_t>((Usable() + request_.tile_points - 1) / request_.tile_points, 1);
    const uint64_t cells = std::min<uint64_t>(wanted_cells, sample.size() / kSampledInCell + 1);
    plan_.tree = CellTree::Divide(std::move(sample), {.tiles = tiles,
                                                      .cells_per_tile = std::max<uint64_t>(cells / tiles, 1),
                                                      .most_extent = MostExtent(),
                                                      .most_edge_points = std::max<uint64_t>(
                                                          request_.memory_bytes / 8 / CellTree::kEdgeBytes, 1024)});
    return absl::OkStatus();
  }

  // Reads all inputs again: finds each point's cell, and puts points of near cells together.
  absl::Status SortIntoBuckets() {
    const std::vector<CellNode>& nodes = plan_.tree.nodes();
    size_t cells = 0;
    for (const CellNode& node : nodes) cells += node.is_cell() ? 1 : 0;
    const uint64_t wanted = Usable() * kSortedBytes / (request_.memory_bytes / 4 + 1) + 1;
    const size_t buckets = std::min<uint64_t>({wanted * 2, kMostBuckets, cells});
    bucket_of_.assign(nodes.size(), 0);
    size_t cell = 0;
    for (size_t node = 0; node < nodes.size(); ++node) {
      if (nodes[node].is_cell()) bucket_of_[node] = static_cast<uint32_t>(cell++ * buckets / cells);
    }
    absl::StatusOr<std::unique_ptr<SpillFile>> spill =
        SpillFile::Create(plan_.directory, buckets, request_.memory_bytes / 8);
    if (!spill.ok()) return spill.status();
    spill_ = *std::move(spill);
    const CellFinder finder(plan_.tree);
    absl::Status status = ForEachBlock(plan_.inputs, Bounds(), [&](const PointBlock& block) {
      if (absl::Status step = Step("sorting", block.first_id, plan_.points); !step.ok()) return step;
      return SortBlock(block, finder);
    });
    if (!status.ok()) return status;
    for (const TileInput& input : plan_.inputs) {
      const absl::StatusOr<InputFile> file = InputFile::Open(input.path);
      if (!file.ok()) return file.status();
      if (!(file->stamp() == input.stamp)) {
        return absl::InvalidArgumentError(absl::StrCat(input.path, " has changed while it was read"));
      }
    }
    plan_.tree.MakeTiles(request_.tile_points + request_.tile_points / 10, MostExtent());
    plan_.tiles = plan_.tree.TileNodes();
    return spill_->Finish();
  }

  // Of the two times kMostSteps that a tile may be long, an eighth is for its halo.
  double MostExtent() const {
    return plan_.is_double ? 1.75 * kMostSteps * plan_.spacing : std::numeric_limits<double>::infinity();
  }

  absl::Status SortBlock(const PointBlock& block, const CellFinder& finder) {
    bool is_double = false;
    if (absl::Status status = ExtractPoints(block, points_, is_double); !status.ok()) return status;
    std::erase_if(points_, [](const TilePoint& point) { return !IsUsable(point); });
    if (plan_.is_double) {
      for (TilePoint& point : points_) point.position = OnLattice(point.position, plan_.spacing);
    }
    cells_.resize(points_.size());
    finder.Find(points_, cells_);
    const size_t record_bytes = sizeof(int32_t) + StoredBytes(plan_.is_double);
    for (size_t i = 0; i < points_.size(); ++i) {
      const int32_t cell = cells_[i];
      plan_.tree.Count(cell, points_[i].position);
      char* record = nullptr;
      absl::Status status = spill_->Extend(bucket_of_[static_cast<size_t>(cell)], record_bytes, record);
      if (!status.ok()) return status;
      std::memcpy(record, &cell, sizeof(cell));
      PackPoint(points_[i], plan_.is_double, record + sizeof(cell));
    }
    return absl::OkStatus();
  }

  absl::Status WriteStore() {
    absl::StatusOr<AtomicFile> store = AtomicFile::Create(plan_.PathOf("points.bin"));
    if (!store.ok()) return absl::DataLossError(store.status().message());
    const std::vector<CellNode>& nodes = plan_.tree.nodes();
    const uint64_t most = std::max<uint64_t>(request_.memory_bytes / 4 / kSortedBytes, 1);
    // Runs of cells of one bucket that are sorted in memory; where a cell alone is larger, it needs no sorting.
    for (size_t begin = 0; begin < nodes.size();) {
      size_t end = begin;
      uint64_t points = 0;
      while (end < nodes.size() && (points == 0 || !nodes[end].is_cell() || nodes[end].count == 0 ||
                                    (bucket_of_[end] == bucket_of_[begin] && points + nodes[end].count <= most))) {
        if (points == 0) begin = end;  // the run starts with a cell that has points
        if (nodes[end].is_cell()) points += nodes[end].count;
        ++end;
      }
      if (points == 0) break;
      if (absl::Status step = Step("writing", nodes[begin].first, Usable()); !step.ok()) return step;
      if (absl::Status status = WriteCells(begin, end, points, *store); !status.ok()) return status;
      if (end == nodes.size() || bucket_of_[end] != bucket_of_[begin]) spill_->Drop(bucket_of_[begin]);
      begin = end;
    }
    spill_.reset();
    absl::Status status = store->Commit();
    return status.ok() ? status : absl::DataLossError(status.message());
  }

  // Writes the points of the cells among the nodes [begin, end), which are in one bucket.
  absl::Status WriteCells(size_t begin, size_t end, uint64_t points, AtomicFile& store) {
    const std::vector<CellNode>& nodes = plan_.tree.nodes();
    const size_t stored = StoredBytes(plan_.is_double), record = sizeof(int32_t) + stored;
    const bool is_one = nodes[begin].count == points;
    std::string sorted(is_one ? 0 : points * stored, '\0');
    std::vector<uint64_t> next(end - begin);
    for (size_t node = begin; node < end; ++node) next[node - begin] = nodes[node].first - nodes[begin].first;
    absl::Status status = spill_->Read(bucket_of_[begin], [&](std::string_view records) {
      std::string kept;
      for (size_t at = 0; at < records.size(); at += record) {
        int32_t cell;
        std::memcpy(&cell, records.data() + at, sizeof(cell));
        const auto node = static_cast<size_t>(cell);
        if (node < begin || node >= end) continue;
        const std::string_view point = records.substr(at + sizeof(cell), stored);
        if (is_one) {
          kept.append(point);
        } else {
          point.copy(sorted.data() + next[node - begin]++ * stored, stored);
        }
      }
      return kept.empty() ? absl::OkStatus() : store.Append(kept);
    });
    if (status.ok() && !is_one) status = store.Append(sorted);
    return status.ok() ? status : absl::DataLossError(status.message());
  }

  uint64_t Usable() const { return plan_.points - plan_.unusable; }
  ReadingBounds Bounds() const { return ReadingBounds::For(request_.memory_bytes); }

  absl::Status Step(const char* step, uint64_t done, uint64_t of) const {
    if (stop_.stop_requested()) return absl::CancelledError("interrupted");
    if (progress_) progress_({step, done, of});
    return absl::OkStatus();
  }

  const PlanRequest& request_;
  const std::stop_token stop_;
  const std::function<void(const PlanProgress& progress)>& progress_;
  PointSample sample_;
  TilePlan plan_;
  std::vector<std::string> notes_;
  std::vector<TilePoint> points_;    // of the block at hand
  std::vector<int32_t> cells_;       // of these
  std::vector<uint32_t> bucket_of_;  // of each node that is a cell
  std::unique_ptr<SpillFile> spill_;
};

}  // namespace

absl::StatusOr<PlanOutcome> PlanTiles(const PlanRequest& request, const std::stop_token& stop,
                                      const std::function<void(const PlanProgress& progress)>& progress) {
  return Planner(request, stop, progress).Plan();
}

}  // namespace curv
