#include "tests/client/tiles/small_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "client/io/table_file.h"
#include "client/tiles/plan_tiles.h"

namespace curv::testing {

ScratchDirectory::ScratchDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "curv-tiles-XXXXXX").string();
  EXPECT_NE(mkdtemp(name.data()), nullptr);
  path_ = name;
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

TilePlan PlanHills(const ScratchDirectory& scratch, size_t points, uint64_t tile_points, const TileReach& reach,
                   const nlohmann::ordered_json& options) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<std::vector<float>> values(6);
  for (size_t i = 0; i < points; ++i) {
    const double distance = std::pow(20.0, unit(random)), angle = std::acos(0.0) * unit(random);
    const double x = distance * std::cos(angle), y = distance * std::sin(angle);
    const double by_x = 0.3 * std::cos(x) * std::cos(y), by_y = -0.3 * std::sin(x) * std::sin(y);
    const double point[] = {x, y, 0.3 * std::sin(x) * std::cos(y), -by_x, -by_y, 1.0};
    for (size_t c = 0; c < 6; ++c) values[c].push_back(static_cast<float>(point[c]));
  }
  PointTable table;
  const char* const names[] = {"x", "y", "z", "nx", "ny", "nz"};
  for (size_t c = 0; c < 6; ++c) table.Set({names[c], std::move(values[c])});
  const std::string cloud = scratch.PathOf("cloud.ply");
  EXPECT_TRUE(SaveTable(table, cloud).ok());
  PlanRequest request;
  request.inputs = {cloud};
  request.directory = scratch.PathOf("plan");
  request.tile_points = tile_points;
  request.memory_bytes = 16 << 20;
  request.reach = reach;
  request.options = options;
  absl::StatusOr<PlanOutcome> outcome = PlanTiles(request, {}, {});
  EXPECT_TRUE(outcome.ok()) << outcome.status();
  return outcome.ok() ? std::move(outcome->plan) : TilePlan();
}

}  // namespace curv::testing
