#include "bench/clouds.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/oriented_cloud.h"
#include "client/io/table_file.h"
#include "client/surfaces/surface.h"
#include "core/job/normals_job.h"
#include "core/job/worker_pool.h"

namespace curvd::bench {
namespace {

constexpr uint64_t kSeed = 1;

void DieUnless(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

BenchCloud Sample(const std::string& name, size_t points) {
  auto surface = curv::MakeSurface(name);
  DieUnless(surface.status());
  auto samples = curv::SampleEvenly(**surface, points, kSeed);
  DieUnless(samples.status());
  BenchCloud cloud{.name = name, .positions = {}, .normals = {}, .true_mean = {}};
  for (const curv::Vec3& position : *samples) {
    const curv::SurfaceGeometry geometry = (*surface)->At(position);
    for (int axis = 0; axis < 3; ++axis) {
      cloud.positions.push_back(static_cast<float>(position[axis]));
      cloud.normals.push_back(static_cast<float>(geometry.normal[axis]));
    }
    cloud.true_mean.push_back(static_cast<float>(geometry.mean));
  }
  return cloud;
}

// The kept file holds the three arrays as they are in memory.
template <typename Stream, typename Transfer>
bool TransferArrays(Stream& file, BenchCloud& cloud, Transfer transfer) {
  for (std::vector<float>* array : {&cloud.positions, &cloud.normals, &cloud.true_mean}) {
    transfer(file, reinterpret_cast<char*>(array->data()), static_cast<std::streamsize>(array->size() * sizeof(float)));
  }
  return file.good();
}

bool Load(const std::string& path, size_t points, BenchCloud& cloud) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) != points * 7 * sizeof(float) || error) return false;
  cloud.positions.resize(3 * points);
  cloud.normals.resize(3 * points);
  cloud.true_mean.resize(points);
  std::ifstream file(path, std::ios::binary);
  return TransferArrays(file, cloud, [](auto& f, char* bytes, auto size) { f.read(bytes, size); });
}

void Save(const std::string& path, BenchCloud& cloud) {
  std::ofstream file(path, std::ios::binary);
  if (!TransferArrays(file, cloud, [](auto& f, char* bytes, auto size) { f.write(bytes, size); })) {
    std::fprintf(stderr, "cannot keep %s\n", path.c_str());
  }
}

// Turns the normals to one side.
void Orient(BenchCloud& cloud) {
  NormalOptions options;
  options.source = NormalSource::kOrient;
  WorkerPool pool(1);
  auto oriented = MakeNormals(ToCloud(cloud), options, pool);
  DieUnless(oriented.status());
  for (size_t i = 0; i < cloud.size(); ++i) {
    std::ranges::copy(oriented->normals.span()[i].normal, cloud.normals.begin() + static_cast<ptrdiff_t>(3 * i));
  }
}

}  // namespace

BenchCloud SurfaceCloud(const std::string& surface, size_t points, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string path = absl::StrCat(folder, "/", surface, "_", points, ".floats");
  BenchCloud cloud{.name = surface, .positions = {}, .normals = {}, .true_mean = {}};
  if (Load(path, points, cloud)) return cloud;
  std::fprintf(stderr, "making %s with %zu points\n", surface.c_str(), points);
  cloud = Sample(surface, points);
  Save(path, cloud);
  return cloud;
}

std::optional<BenchCloud> ArmadilloCloud() {
  const std::string path = BENCH_SCAN_DIR "/armadillo100k.ply";
  if (!std::filesystem::exists(path)) return std::nullopt;
  auto table = curv::LoadTable(path);
  DieUnless(table.status());
  auto packed = curv::ExtractCloud(*table);
  DieUnless(packed.status());
  const auto& source = std::get<curv::PackedCloud<float>>(*packed);
  std::vector<size_t> order(source.positions.size() / 3);
  std::iota(order.begin(), order.end(), size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937_64(kSeed));
  BenchCloud cloud{.name = "armadillo", .positions = {}, .normals = {}, .true_mean = {}};
  for (size_t i : order) {
    for (size_t axis = 0; axis < 3; ++axis) {
      cloud.positions.push_back(source.positions[3 * i + axis]);
      cloud.normals.push_back(source.normals[3 * i + axis]);
    }
  }
  Orient(cloud);
  return cloud;
}

Cloud ToCloud(const BenchCloud& cloud) {
  const auto bytes = [](const std::vector<float>& array) {
    return std::string_view(reinterpret_cast<const char*>(array.data()), array.size() * sizeof(float));
  };
  Cloud result;
  result.Expect(cloud.size());
  DieUnless(result.Append(bytes(cloud.positions), bytes(cloud.normals)));
  DieUnless(result.Finish());
  return result;
}

}  // namespace curvd::bench
