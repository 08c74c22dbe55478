// Plans, cells and results that are damaged, or made to do damage, end in an error that names the file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "client/cli/tiles/tile_options.h"
#include "client/io/archive/zip.h"
#include "client/tiles/merge_tiles.h"
#include "client/tiles/run_tiles.h"
#include "client/tiles/tile_status.h"
#include "tests/client/tiles/small_plan.h"

namespace curv {
namespace {

using testing::PlanHills;
using testing::ScratchDirectory;

constexpr int kMutations = 300;

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

// One of the things that happen to bytes: flipped, cut off, doubled, a number replaced by an extreme one.
std::string Mutated(std::string bytes, std::mt19937_64& random) {
  static constexpr const char* kNumbers[] = {
      "-1",    "0",    "18446744073709551615", "1e308",     "1e-320", "0.5", "null", "[]", "{}",
      "\"x\"", "true", "9223372036854775808",  "4294967296"};
  const size_t at = random() % bytes.size();
  switch (random() % 5) {
    case 0:
      bytes[at] = static_cast<char>(random());
      return bytes;
    case 1:
      return bytes.substr(0, at);
    case 2:
      return bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 200));
    case 3: {
      uint64_t value = random() % 2 == 0 ? random() : ~uint64_t{0} >> (random() % 64);
      std::memcpy(bytes.data() + std::min(at & ~size_t{7}, bytes.size() - sizeof(value)), &value, sizeof(value));
      return bytes;
    }
    default: {
      const size_t begin = bytes.find_first_of("0123456789", at);
      if (begin == std::string::npos) return bytes.substr(1);
      const size_t end = std::min(bytes.find_first_not_of("0123456789", begin), bytes.size());
      return bytes.replace(begin, end - begin, kNumbers[random() % std::size(kNumbers)]);
    }
  }
}

absl::StatusOr<TileAnswer> Zeros(const FloatArrays&, const std::vector<uint32_t>& queries) {
  TileAnswer answer;
  answer.columns.push_back({"mean_curvature", std::vector<float>(queries.size())});
  answer.radii.resize(queries.size());
  answer.is_unusable.resize(queries.size());
  return answer;
}

PointTable Join(PointTable input, std::vector<Column> results) {
  for (Column& column : results) input.Set(std::move(column));
  return input;
}

class DamagedFilesTest : public ::testing::Test {
 protected:
  DamagedFilesTest() {
    const TilePlan plan =
        PlanHills(scratch_, 3000, 800, {.neighbor_count = 20, .radius = 0.0, .factor = 1.0}, JsonOf(EstimateOptions()));
    directory_ = plan.directory;
    EXPECT_TRUE(RunTiles(plan, {}, Zeros, {}, {}).ok());
    plan_ = ReadFile(plan.PathOf("plan.json"));
    cells_ = ReadFile(plan.PathOf("cells.bin"));
    result_ = ReadFile(plan.PathOf("results/tile-000000"));
  }

  // Does all that commands do with a plan; an error names a file or what is wrong. Returns whether there was one.
  bool UseAll() {
    const absl::StatusOr<TilePlan> plan = LoadPlan(directory_);
    if (!plan.ok()) {
      EXPECT_NE(plan.status().message().find(directory_), std::string::npos) << plan.status();
      return true;
    }
    const absl::Status options = OptionsOf(plan->options).status();
    const TileStatus status = StatusOf(*plan);
    EXPECT_LE(status.tiles_done, status.tiles);
    const bool has_faults = !VerifyTiles(*plan).empty();
    for (const TileFault& fault : VerifyTiles(*plan)) {
      EXPECT_NE(fault.status.message().find(directory_), std::string::npos) << fault.status;
    }
    const absl::Status merged = MergeTiles(*plan, scratch_.PathOf("out.ply"), {}, Join, {}, {}).status();
    EXPECT_TRUE(merged.ok() || !merged.message().empty());
    return has_faults || !options.ok() || !merged.ok();
  }

  void Write(const char* name, const std::string& bytes) { WriteFile(directory_ + "/" + name, bytes); }

  ScratchDirectory scratch_;
  std::string directory_, plan_, cells_, result_;
};

TEST_F(DamagedFilesTest, AreWholeBefore) { EXPECT_FALSE(UseAll()); }

TEST_F(DamagedFilesTest, AnyPlanIsReadOrRefused) {
  std::mt19937_64 random(1);
  int refused = 0;
  for (int i = 0; i < kMutations; ++i) {
    Write("plan.json", Mutated(plan_, random));
    refused += UseAll() ? 1 : 0;
  }
  EXPECT_GT(refused, kMutations / 2);  // the rest changed what nothing depends on
}

TEST_F(DamagedFilesTest, AnyCellsAreReadOrRefusedThoughTheirChecksumFits) {
  std::mt19937_64 random(2);
  auto json = nlohmann::ordered_json::parse(plan_);
  Write("cells.bin", Mutated(cells_, random));
  EXPECT_TRUE(UseAll()) << "the checksum was not compared";
  int refused = 0;
  for (int i = 0; i < kMutations; ++i) {
    const std::string cells = Mutated(cells_, random);
    Write("cells.bin", cells);
    json["cells_crc32"] = Crc32(0, cells);
    Write("plan.json", json.dump());
    refused += UseAll() ? 1 : 0;
  }
  EXPECT_GT(refused, kMutations / 2);
}

TEST_F(DamagedFilesTest, AnyResultIsReadOrRefused) {
  std::mt19937_64 random(3);
  const std::string line = result_.substr(0, result_.find('\n')), rows = result_.substr(line.size());
  for (int i = 0; i < kMutations; ++i) {
    const bool of_line = i % 2 == 0;
    Write("results/tile-000000", of_line ? Mutated(line, random) + rows : line + Mutated(rows, random));
    UseAll();
  }
}

TEST_F(DamagedFilesTest, NestingTakesNoStack) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  auto json = nlohmann::ordered_json::parse(plan_);
  json["options"] = "HERE";
  std::string text = json.dump();
  text.replace(text.find("\"HERE\""), 6, deep);
  Write("plan.json", text);
  const absl::StatusOr<TilePlan> plan = LoadPlan(directory_);
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.status().message().find("nested deeper"), std::string::npos) << plan.status();
}

TEST_F(DamagedFilesTest, ErrorsAreNotThoseOfTheJsonLibrary) {
  const auto message = [this] { return std::string(LoadPlan(directory_).status().message()); };
  const std::string start = directory_ + "/plan.json: it is no plan of curv tiles: ";
  Write("plan.json", plan_.substr(0, 100));
  EXPECT_EQ(message(), start + "the JSON ends too early, after 100 bytes. Plan again");
  Write("plan.json", "{\"format\": !" + plan_.substr(12));
  EXPECT_EQ(message(), start + "the JSON is damaged at byte 12. Plan again");
  Write("plan.json", "{\"points\": 1e999}");
  EXPECT_EQ(message(), start + "a number is larger than a double can be. Plan again");
  Write("plan.json", "[]");
  EXPECT_EQ(message(), start + "expected an object with the member format. Plan again");
  for (const char* name : {"format", "version", "id", "inputs", "scalar", "reach", "options", "columns"}) {
    auto json = nlohmann::ordered_json::parse(plan_);
    json.erase(name);
    Write("plan.json", json.dump());
    EXPECT_EQ(message(), start + name + " is missing. Plan again");
  }
  Write("plan.json", plan_);
  Write("results/tile-000000", "{}\n");
  EXPECT_EQ(std::string(ReadTileResult(*LoadPlan(directory_), 0).status().message()),
            directory_ +
                "/results/tile-000000: it is no result of a tile: format is missing. Remove it, and curv tiles "
                "run makes it again");
}

TEST_F(DamagedFilesTest, OptionsAreReadAsTheyShouldBe) {
  for (const char* name : {"estimator", "even_weights", "quantities", "skip_invalid"}) {
    auto json = JsonOf(EstimateOptions());
    json[name] = 1;
    const std::string message(OptionsOf(json).status().message());
    EXPECT_EQ(message.find("the plan's options: " + std::string(name) + " is n"), 0u) << message;
    EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
  }
}

TEST_F(DamagedFilesTest, ErrorsNameTheMember) {
  const struct {
    const char* name;
    nlohmann::ordered_json value;
  } cases[] = {{"points", -1},
               {"points", 2999},
               {"unusable", 1},
               {"spacing", 0.5},
               {"tile_points", 1e300},
               {"memory_bytes", "1GiB"},
               {"reach", {{"neighbor_count", 1.5}}},
               {"tiles", 1}};
  for (const auto& [name, value] : cases) {
    auto json = nlohmann::ordered_json::parse(plan_);
    json[name] = value;
    Write("plan.json", json.dump());
    const absl::StatusOr<TilePlan> plan = LoadPlan(directory_);
    ASSERT_FALSE(plan.ok()) << name;
    const std::string expected = value.is_object()                 ? "neighbor_count"
                                 : std::string(name) == "unusable" ? "points"
                                                                   : name;
    EXPECT_NE(plan.status().message().find(expected), std::string::npos) << plan.status();
  }
}

}  // namespace
}  // namespace curv
