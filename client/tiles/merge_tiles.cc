#include "client/tiles/merge_tiles.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/binary.h"
#include "client/io/point_status.h"
#include "client/io/writing/table_stream.h"
#include "client/tiles/input_points.h"
#include "client/tiles/spill_file.h"
#include "client/tiles/tile_result.h"

namespace curv {
namespace {

constexpr size_t kIdBytes = sizeof(uint64_t);

using Columns = std::vector<std::pair<std::string, ScalarKind>>;

// A row without its id of a point that is in no tile: no numbers, and the status that says why.
std::string RowOfUnusable(const Columns& columns) {
  std::string row;
  for (const auto& [name, kind] : columns) {
    const size_t at = row.size();
    row.resize(at + BytesOf(kind), '\0');
    if (name == "status") {
      row[at] = static_cast<char>(PointStatus::kInvalidInput);
    } else if (kind == ScalarKind::kFloat32) {
      const float none = std::numeric_limits<float>::quiet_NaN();
      std::memcpy(row.data() + at, &none, sizeof(none));
    } else if (kind == ScalarKind::kFloat64) {
      const double none = std::numeric_limits<double>::quiet_NaN();
      std::memcpy(row.data() + at, &none, sizeof(none));
    }
  }
  return row;
}

// The results of all tiles by the points' ids: a range of ids at a time is in memory.
class ResultsInOrder {
 public:
  explicit ResultsInOrder(const TilePlan& plan) : plan_(plan) {}

  // Looks at what the tiles say, and sorts their rows.
  absl::Status Prepare() {
    for (size_t tile = 0; tile < plan_.tiles.size(); ++tile) {
      absl::StatusOr<TileResult> result = ReadTileResult(plan_, tile);
      if (absl::IsNotFound(result.status())) {
        return absl::FailedPreconditionError(
            absl::StrCat("tile ", tile, " of ", plan_.tiles.size(), " is not done: curv tiles run ", plan_.directory));
      }
      if (!result.ok()) return result.status();
      if (tile == 0) columns_ = result->columns;
      if (result->columns != columns_) {
        return absl::FailedPreconditionError(
            absl::StrCat("tile ", tile, " has other columns than tile 0: servers of different versions?"));
      }
      row_bytes_ = result->row_bytes();
      results_.push_back(*std::move(result));
    }
    unusable_ = RowOfUnusable(columns_);
    range_rows_ = std::max<uint64_t>(plan_.memory_bytes / 2 / row_bytes_, 1);
    if (plan_.points <= range_rows_) return absl::OkStatus();
    const size_t ranges = (plan_.points + range_rows_ - 1) / range_rows_;
    absl::StatusOr<std::unique_ptr<SpillFile>> spill =
        SpillFile::Create(plan_.directory, ranges, plan_.memory_bytes / 8);
    if (!spill.ok()) return spill.status();
    spill_ = *std::move(spill);
    absl::Status status = ForEachRow([this](uint64_t id, std::string_view row) -> absl::Status {
      char* record = nullptr;
      absl::Status extended = spill_->Extend(id / range_rows_, row.size(), record);
      if (extended.ok()) row.copy(record, row.size());
      return extended;
    });
    return status.ok() ? spill_->Finish() : status;
  }

  const Columns& columns() const { return columns_; }
  // Bytes of a row without its id.
  size_t row_bytes() const { return row_bytes_ - kIdBytes; }

  // Appends the rows of the points `first` to `first + count`. REQUIRES: calls come in the order of the points.
  absl::Status Append(uint64_t first, uint64_t count, std::string& rows) {
    for (uint64_t id = first; id < first + count;) {
      if (id / range_rows_ != loaded_) {
        if (absl::Status status = Load(id / range_rows_); !status.ok()) return status;
      }
      const uint64_t end = std::min(first + count, (*loaded_ + 1) * range_rows_);
      rows.append(range_, (id - *loaded_ * range_rows_) * row_bytes(), (end - id) * row_bytes());
      id = end;
    }
    return absl::OkStatus();
  }

 private:
  absl::Status ForEachRow(const std::function<absl::Status(uint64_t id, std::string_view row)>& visit) const {
    for (const TileResult& result : results_) {
      absl::Status status = ReadTileRows(plan_, result, [&](std::string_view rows) { return Split(rows, visit); });
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status Split(std::string_view rows,
                     const std::function<absl::Status(uint64_t id, std::string_view row)>& visit) const {
    for (size_t at = 0; at < rows.size(); at += row_bytes_) {
      uint64_t id;
      std::memcpy(&id, rows.data() + at, kIdBytes);
      if (id >= plan_.points) return absl::FailedPreconditionError(absl::StrCat("a result is of point ", id));
      if (absl::Status status = visit(id, rows.substr(at, row_bytes_)); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status Load(uint64_t range) {
    const uint64_t first = range * range_rows_, count = std::min(range_rows_, plan_.points - first);
    range_.clear();
    range_.reserve(count * row_bytes());
    for (uint64_t i = 0; i < count; ++i) range_ += unusable_;
    loaded_ = range;
    const auto place = [&](uint64_t id, std::string_view row) {
      row.substr(kIdBytes).copy(range_.data() + (id - first) * row_bytes(), row_bytes());
      return absl::OkStatus();
    };
    if (spill_ == nullptr) return ForEachRow(place);
    return spill_->Read(range, [&](std::string_view rows) { return Split(rows, place); });
  }

  const TilePlan& plan_;
  std::vector<TileResult> results_;
  Columns columns_;
  size_t row_bytes_ = 0;
  uint64_t range_rows_ = 0;
  std::string unusable_;
  std::unique_ptr<SpillFile> spill_;  // only where not all fits into memory; a bucket for each range
  std::optional<uint64_t> loaded_;
  std::string range_;
};

// Writes tables one after the other, or together where the format asks for that.
class Output {
 public:
  Output(const TilePlan& plan, std::string path, SaveOptions save)
      : plan_(plan), path_(std::move(path)), save_(std::move(save)), streams_(TableStream::CanWrite(path_, save_)) {}

  absl::Status Append(PointTable table) {
    if (!started_) {
      if (absl::Status status = Start(table); !status.ok()) return status;
    }
    if (streams_) return AsOutput(stream_->Append(table));
    if (whole_.columns().empty()) {
      whole_ = std::move(table);
      return absl::OkStatus();
    }
    std::vector<Column> columns = whole_.Release();
    for (size_t c = 0; c < columns.size(); ++c) {
      std::visit(
          [&](auto& values) {
            const auto& more = std::get<std::decay_t<decltype(values)>>(table.columns()[c].values);
            values.insert(values.end(), more.begin(), more.end());
          },
          columns[c].values);
    }
    for (Column& column : columns) whole_.Set(std::move(column));
    return absl::OkStatus();
  }

  absl::Status Commit() { return AsOutput(streams_ ? stream_->Commit() : SaveTable(whole_, path_, save_)); }

 private:
  static absl::Status AsOutput(const absl::Status& status) {
    return status.ok() ? status : absl::DataLossError(status.message());
  }

  absl::Status Start(const PointTable& like) {
    started_ = true;
    if (streams_) {
      absl::StatusOr<std::unique_ptr<TableStream>> stream = TableStream::Create(path_, save_, like, plan_.points);
      if (!stream.ok()) return AsOutput(stream.status());
      stream_ = *std::move(stream);
      return absl::OkStatus();
    }
    uint64_t row_bytes = 0;
    for (const Column& column : like.columns()) row_bytes += BytesOf(column.kind());
    const uint64_t bytes = plan_.points * row_bytes, most = plan_.memory_bytes / 4;
    if (bytes <= most) return absl::OkStatus();
    return absl::ResourceExhaustedError(absl::StrCat(path_, ": this format is written as a whole, and the result has ",
                                                     bytes, " bytes, of which the plan's memory bound allows ", most,
                                                     ": write .ply, .pcd, .npy, .csv or .xyz"));
  }

  const TilePlan& plan_;
  const std::string path_;
  const SaveOptions save_;
  const bool streams_;
  bool started_ = false;
  std::unique_ptr<TableStream> stream_;
  PointTable whole_;
};

// The columns of the input that go into the result: "NAME KIND" as in the plan, whose kinds all inputs share.
PointTable KeptColumns(const PointTable& input, const TilePlan& plan) {
  PointTable kept;
  kept.viewpoint = input.viewpoint;
  kept.pcd = input.pcd;
  kept.las = input.las;
  for (const std::string& column : plan.columns) {
    const Column* found = input.Find(column.substr(0, column.rfind(' ')));
    if (found != nullptr && ColumnText(*found) == column) kept.Set(*found);
  }
  return kept;
}

std::vector<Column> ToColumns(const Columns& columns, std::string_view rows, uint64_t count, size_t row_bytes) {
  std::vector<Column> made;
  made.reserve(columns.size());
  std::vector<RowField> fields;
  size_t offset = 0;
  for (const auto& [name, kind] : columns) {
    made.push_back({name, MakeValues(kind)});
    fields.push_back({offset, &made.back()});
    offset += BytesOf(kind);
  }
  AppendRows(rows, count, row_bytes, fields, /*swap=*/false);
  return made;
}

// Adds to the counts what a block of results says. A value that this client does not know counts as unspecified.
void CountStatuses(const std::vector<Column>& columns, StatusCounts& counts) {
  for (const Column& column : columns) {
    const auto* values = std::get_if<std::vector<uint8_t>>(&column.values);
    if (column.name != "status" || values == nullptr) continue;
    for (const uint8_t value : *values) ++counts[value < counts.size() ? value : 0];
  }
}

}  // namespace

absl::StatusOr<StatusCounts> MergeTiles(const TilePlan& plan, const std::string& output, const SaveOptions& save,
                                        const ResultJoin& join, const std::stop_token& stop,
                                        const std::function<void(uint64_t points)>& progress) {
  ResultsInOrder results(plan);
  if (absl::Status status = results.Prepare(); !status.ok()) return status;
  Output out(plan, output, save);
  StatusCounts counts{};
  std::string rows;
  absl::Status status =
      ForEachPlannedBlock(plan, ReadingBounds::For(plan.memory_bytes), [&](const PointBlock& block) -> absl::Status {
        if (stop.stop_requested()) return absl::CancelledError("interrupted");
        rows.clear();
        const uint64_t count = block.table->size();
        if (absl::Status status = results.Append(block.first_id, count, rows); !status.ok()) return status;
        PointTable kept = KeptColumns(*block.table, plan);
        if (kept.columns().size() != plan.columns.size()) {
          return absl::FailedPreconditionError(absl::StrCat(plan.inputs[block.input].path, ": in the block at point ",
                                                            block.first_id,
                                                            " columns have other types than in the first one"));
        }
        std::vector<Column> columns = ToColumns(results.columns(), rows, count, results.row_bytes());
        CountStatuses(columns, counts);
        if (absl::Status status = out.Append(join(std::move(kept), std::move(columns))); !status.ok()) return status;
        if (progress) progress(block.first_id + count);
        return absl::OkStatus();
      });
  if (status.ok()) status = out.Commit();
  if (!status.ok()) return status;
  return counts;
}

}  // namespace curv
