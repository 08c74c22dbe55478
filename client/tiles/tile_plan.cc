#include "client/tiles/tile_plan.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/archive/zip.h"
#include "client/io/atomic_file.h"
#include "client/tiles/reading/json_fields.h"
#include "client/tiles/tile_point.h"

namespace curv {
namespace {

constexpr char kFormat[] = "curv tiles";
constexpr int kVersion = 1;
constexpr char kPlanFile[] = "plan.json";
constexpr char kCellsFile[] = "cells.bin";
constexpr uint64_t kMostTilePoints = uint64_t{1} << 40;
constexpr double kMostReach = 1e6;

absl::Status WriteWhole(const std::string& path, std::string_view bytes) {
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  absl::Status status = file.status();
  if (status.ok()) status = file->Append(bytes);
  if (status.ok()) status = file->Commit();
  return status.ok() ? status : absl::DataLossError(status.message());
}

absl::Status Damaged(const std::string& path, const std::string& what) {
  return absl::FailedPreconditionError(absl::StrCat(path, ": ", what));
}

absl::StatusOr<std::string> ReadWhole(const std::string& path) {
  const absl::StatusOr<InputFile> file = InputFile::Open(path);
  if (!file.ok()) return absl::FailedPreconditionError(file.status().message());
  absl::StatusOr<std::string> bytes = file->Read(0, file->stamp().bytes);
  if (!bytes.ok()) return absl::FailedPreconditionError(bytes.status().message());
  return bytes;
}

nlohmann::ordered_json JsonOf(const TilePlan& plan, std::string_view cells) {
  nlohmann::ordered_json inputs = nlohmann::ordered_json::array();
  for (const TileInput& input : plan.inputs) {
    inputs.push_back({{"path", input.path},
                      {"format", input.format},
                      {"points", input.points},
                      {"bytes", input.stamp.bytes},
                      {"modified_ns", input.stamp.modified_ns}});
  }
  return {
      {"format", kFormat},
      {"version", kVersion},
      {"id", plan.id},
      {"inputs", inputs},
      {"points", plan.points},
      {"unusable", plan.unusable},
      {"scalar", plan.is_double ? "float64" : "float32"},
      {"spacing", plan.spacing},
      {"memory_bytes", plan.memory_bytes},
      {"tile_points", plan.tile_points},
      {"reach",
       {{"neighbor_count", plan.reach.neighbor_count}, {"radius", plan.reach.radius}, {"factor", plan.reach.factor}}},
      {"options", plan.options},
      {"columns", plan.columns},
      {"tiles", plan.tiles.size()},
      {"cells_bytes", cells.size()},
      {"cells_crc32", Crc32(0, cells)}};
}

// Throws BadField where a member lacks, or is not what a plan has.
void ReadJson(const nlohmann::ordered_json& json, TilePlan& plan) {
  plan.id = TextOf(json, "id");
  plan.points = UnsignedOf(json, "points");
  uint64_t counted = 0;
  for (const nlohmann::ordered_json& input : ArrayOf(json, "inputs")) {
    plan.inputs.push_back({TextOf(input, "path"),
                           TextOf(input, "format"),
                           UnsignedOf(input, "points", plan.points - counted),
                           {UnsignedOf(input, "bytes"), IntegerOf(input, "modified_ns")}});
    counted += plan.inputs.back().points;
  }
  if (counted != plan.points) throw BadField("points is not the sum of those of the inputs");
  plan.unusable = UnsignedOf(json, "unusable", plan.points);
  plan.is_double = TextOf(json, "scalar") == "float64";
  plan.spacing = NumberOf(json, "spacing", 0.0, std::numeric_limits<double>::max());
  if (plan.is_double != (plan.spacing > 0.0)) throw BadField("spacing is that of the other scalar");
  plan.memory_bytes = UnsignedOf(json, "memory_bytes");
  plan.tile_points = UnsignedOf(json, "tile_points", kMostTilePoints);
  const nlohmann::ordered_json& reach = MemberOf(json, "reach");
  plan.reach.neighbor_count = static_cast<uint32_t>(UnsignedOf(reach, "neighbor_count", ~uint32_t{0}));
  plan.reach.radius = NumberOf(reach, "radius", 0.0, std::numeric_limits<double>::max());
  plan.reach.factor = NumberOf(reach, "factor", 0.0, kMostReach);
  plan.options = MemberOf(json, "options");
  plan.columns = TextsOf(json, "columns");
}

// Reads the tree that plan.json tells of. Throws BadField.
absl::Status ReadCells(const nlohmann::ordered_json& json, TilePlan& plan) {
  const std::string path = plan.PathOf(kCellsFile);
  const absl::StatusOr<std::string> cells = ReadWhole(path);
  if (!cells.ok()) return cells.status();
  if (Crc32(0, *cells) != UnsignedOf(json, "cells_crc32")) {
    return Damaged(path, "its checksum is not the one in plan.json: plan again");
  }
  absl::StatusOr<CellTree> tree = CellTree::Parse(*cells);
  if (!tree.ok()) return Damaged(path, std::string(tree.status().message()));
  plan.tree = *std::move(tree);
  plan.tiles = plan.tree.TileNodes();
  if (plan.tiles.size() != UnsignedOf(json, "tiles")) throw BadField("tiles is not what cells.bin has");
  if (plan.tree.root().count != plan.points - plan.unusable) throw BadField("points is not what cells.bin has");
  return absl::OkStatus();
}

}  // namespace

absl::Status SavePlan(const TilePlan& plan) {
  const std::string cells = plan.tree.Bytes();
  if (absl::Status status = WriteWhole(plan.PathOf(kCellsFile), cells); !status.ok()) return status;
  return WriteWhole(plan.PathOf(kPlanFile),
                    JsonOf(plan, cells).dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

absl::StatusOr<TilePlan> LoadPlan(const std::string& directory) {
  TilePlan plan;
  plan.directory = directory;
  const std::string path = plan.PathOf(kPlanFile);
  const absl::StatusOr<std::string> text = ReadWhole(path);
  if (!text.ok()) {
    return absl::FailedPreconditionError(
        absl::StrCat(text.status().message(), ". curv tiles plan IN... -o ", directory, " makes a plan"));
  }
  try {
    const auto json = ParseFields(*text);
    if (MemberOf(json, "format") != kFormat) return Damaged(path, "it is not the plan of curv tiles");
    if (MemberOf(json, "version") != kVersion) {
      return Damaged(path, absl::StrCat("its version is ", json["version"].dump(), ", this curv knows ", kVersion,
                                        ": use the curv that made it, or plan again"));
    }
    ReadJson(json, plan);
    if (absl::Status status = ReadCells(json, plan); !status.ok()) return status;
  } catch (const BadField& error) {
    return Damaged(path, absl::StrCat("it is no plan of curv tiles: ", error.what(), ". Plan again"));
  }
  const absl::StatusOr<InputFile> store = InputFile::Open(plan.PathOf("points.bin"));
  if (!store.ok()) return absl::FailedPreconditionError(store.status().message());
  const uint64_t points = plan.tree.root().count, stored = StoredBytes(plan.is_double);
  if (store->stamp().bytes / stored != points || store->stamp().bytes % stored != 0) {
    return Damaged(store->path(), absl::StrCat("it has ", store->stamp().bytes, " bytes, expected ", stored,
                                               " for each of ", points, " points"));
  }
  return plan;
}

absl::Status RemovePlan(const TilePlan& plan) {
  // The plan first: what is left of others is no plan.
  for (const char* name : {kPlanFile, kCellsFile, "points.bin", "results", "locks"}) {
    std::error_code error;
    std::filesystem::remove_all(plan.PathOf(name), error);
    if (error) return absl::DataLossError(absl::StrCat("cannot remove ", plan.PathOf(name), ": ", error.message()));
  }
  std::error_code not_empty;
  std::filesystem::remove(plan.directory, not_empty);
  return absl::OkStatus();
}

}  // namespace curv
