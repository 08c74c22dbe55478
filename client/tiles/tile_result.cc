#include "client/tiles/tile_result.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/io/archive/zip.h"
#include "client/io/atomic_file.h"
#include "client/io/blocks/input_file.h"
#include "client/io/writing/rows.h"
#include "client/tiles/reading/json_fields.h"

namespace curv {
namespace {

constexpr char kFormat[] = "curv tile result";
constexpr int kVersion = 1;
constexpr size_t kIdBytes = sizeof(uint64_t);
constexpr size_t kMostLine = 1 << 20;
constexpr size_t kRowsAtATime = 1 << 14;
constexpr double kMostSeconds = 1e12;  // far beyond all of us
constexpr ScalarKind kLastKind = ScalarKind::kFloat64;

std::string PathOf(const TilePlan& plan, size_t tile) {
  return plan.PathOf(absl::StrFormat("results/tile-%06d", tile));
}

absl::Status Damaged(const std::string& path, const std::string& what) {
  return absl::FailedPreconditionError(
      absl::StrCat(path, ": ", what, ". Remove it, and curv tiles run makes it again"));
}

std::string RowsOf(const std::vector<uint64_t>& ids, const std::vector<Column>& columns, size_t row_bytes) {
  std::string rows(ids.size() * row_bytes, '\0');
  for (size_t i = 0; i < ids.size(); ++i) std::memcpy(rows.data() + i * row_bytes, &ids[i], kIdBytes);
  size_t at = kIdBytes;
  for (const Column& column : columns) {
    std::visit(
        [&](const auto& values) {
          for (size_t i = 0; i < ids.size(); ++i) {
            std::memcpy(rows.data() + i * row_bytes + at, &values[i], sizeof(values[0]));
          }
        },
        column.values);
    at += BytesOf(column.kind());
  }
  return rows;
}

nlohmann::ordered_json JsonOf(const TilePlan& plan, const TileResult& result) {
  nlohmann::ordered_json columns = nlohmann::ordered_json::array();
  for (const auto& [name, kind] : result.columns) {
    columns.push_back({{"name", name}, {"kind", static_cast<int>(kind)}, {"bytes", BytesOf(kind)}});
  }
  return {{"format", kFormat},
          {"version", kVersion},
          {"plan", plan.id},
          {"tile", result.tile},
          {"points", result.points},
          {"columns", columns},
          {"crc32", result.crc32},
          {"halo_points", result.halo_points},
          {"uncertain_points", result.uncertain_points},
          {"repair_points", result.repair_points},
          {"coarse_points", result.coarse_points},
          {"opposed_normals", result.has_opposed_normals},
          {"normals_off_surface", result.has_normals_off_surface},
          {"seconds", result.seconds},
          {"finished", result.finished}};
}

// Throws BadField where a member lacks, or is not what a result has.
TileResult FromJson(const nlohmann::ordered_json& json) {
  TileResult result;
  result.tile = UnsignedOf(json, "tile");
  result.points = UnsignedOf(json, "points");
  for (const nlohmann::ordered_json& column : ArrayOf(json, "columns")) {
    const auto kind = static_cast<ScalarKind>(UnsignedOf(column, "kind", static_cast<uint64_t>(kLastKind)));
    result.columns.emplace_back(TextOf(column, "name"), kind);
  }
  result.crc32 = static_cast<uint32_t>(UnsignedOf(json, "crc32", ~uint32_t{0}));
  result.halo_points = UnsignedOf(json, "halo_points");
  result.uncertain_points = UnsignedOf(json, "uncertain_points");
  result.repair_points = UnsignedOf(json, "repair_points");
  result.coarse_points = UnsignedOf(json, "coarse_points");
  result.has_opposed_normals = FlagOf(json, "opposed_normals");
  result.has_normals_off_surface = FlagOf(json, "normals_off_surface");
  result.seconds = NumberOf(json, "seconds", 0.0, kMostSeconds);
  result.finished = NumberOf(json, "finished", 0.0, kMostSeconds);
  return result;
}

}  // namespace

size_t TileResult::row_bytes() const {
  size_t bytes = kIdBytes;
  for (const auto& [name, kind] : columns) bytes += BytesOf(kind);
  return bytes;
}

absl::Status WriteTileResult(const TilePlan& plan, TileResult result, const std::vector<uint64_t>& ids,
                             const std::vector<Column>& columns) {
  result.columns.clear();
  for (const Column& column : columns) result.columns.emplace_back(column.name, column.kind());
  const std::string rows = RowsOf(ids, columns, result.row_bytes());
  result.crc32 = Crc32(0, rows);
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(PathOf(plan, result.tile));
  absl::Status status = file.status();
  if (status.ok()) status = file->Append(JsonOf(plan, result).dump() + "\n");
  if (status.ok()) status = file->Append(rows);
  if (status.ok()) status = file->Commit();
  return status.ok() ? status : absl::DataLossError(status.message());
}

absl::StatusOr<TileResult> ReadTileResult(const TilePlan& plan, size_t tile) {
  const std::string path = PathOf(plan, tile);
  const absl::StatusOr<InputFile> file = InputFile::Open(path);
  if (!file.ok()) return absl::NotFoundError(file.status().message());
  const absl::StatusOr<std::string> start = file->Read(0, std::min<uint64_t>(file->stamp().bytes, kMostLine));
  if (!start.ok()) return Damaged(path, std::string(start.status().message()));
  const size_t line = start->find('\n');
  if (line == std::string::npos) return Damaged(path, "it does not start with a line of JSON");
  TileResult result;
  try {
    const auto json = ParseFields(std::string_view(*start).substr(0, line));
    if (MemberOf(json, "format") != kFormat || MemberOf(json, "version") != kVersion)
      return Damaged(path, "it is of another version");
    if (MemberOf(json, "plan") != plan.id) return Damaged(path, "it is of another plan");
    result = FromJson(json);
  } catch (const BadField& error) {
    return Damaged(path, absl::StrCat("it is no result of a tile: ", error.what()));
  }
  result.rows_at = line + 1;
  if (result.tile != tile || result.points != plan.tile(tile).count) return Damaged(path, "it is of another tile");
  const uint64_t expected = result.rows_at + result.points * result.row_bytes();
  if (file->stamp().bytes == expected) return result;
  return Damaged(path, absl::StrCat("it has ", file->stamp().bytes, " bytes, expected ", expected));
}

absl::Status ReadTileRows(const TilePlan& plan, const TileResult& result,
                          const std::function<absl::Status(std::string_view rows)>& take) {
  const std::string path = PathOf(plan, result.tile);
  const absl::StatusOr<InputFile> file = InputFile::Open(path);
  if (!file.ok()) return Damaged(path, std::string(file.status().message()));
  const size_t row_bytes = result.row_bytes();
  uint32_t crc32 = 0;
  std::string rows;
  for (uint64_t done = 0; done < result.points;) {
    const uint64_t now = std::min<uint64_t>(kRowsAtATime, result.points - done);
    rows.resize(now * row_bytes);
    absl::Status status = file->ReadAll(result.rows_at + done * row_bytes, rows.size(), rows.data());
    if (!status.ok()) return Damaged(path, std::string(status.message()));
    crc32 = Crc32(crc32, rows);
    if (status = take(rows); !status.ok()) return status;
    done += now;
  }
  if (crc32 == result.crc32) return absl::OkStatus();
  return Damaged(path, "the checksum of its rows is not the one that it tells");
}

}  // namespace curv
