// Writes a cloud of uneven density with its exact curvature: paper_cloud SURFACE KIND OUT
// KIND is a way to spread samples, as samples.h has them, or a file with samples of the surface.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "bench/paper/samples.h"
#include "client/io/table_file.h"

namespace curvd::bench {
namespace {

template <typename Value>
void AddColumn(const Samples& samples, const std::string& name, Value value, curv::PointTable& table) {
  std::vector<float> values(samples.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(value(i));
  table.Set({name, std::move(values)});
}

curv::PointTable ToTable(const Samples& samples) {
  curv::PointTable table;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    AddColumn(
        samples, name, [&](size_t i) { return samples.positions[i][axis]; }, table);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("n") + "xyz"[axis];
    AddColumn(
        samples, name, [&](size_t i) { return samples.normals[i][axis]; }, table);
  }
  AddColumn(
      samples, "true_mean", [&](size_t i) { return samples.truth[i].mean; }, table);
  AddColumn(
      samples, "true_gaussian", [&](size_t i) { return samples.truth[i].gaussian; }, table);
  return table;
}

std::optional<Samples> Make(const std::string& surface, const std::string& kind) {
  if (std::find(std::begin(kSampleSpreads), std::end(kSampleSpreads), kind) != std::end(kSampleSpreads)) {
    return SampleAs(kind, surface, 12'500, 1);
  }
  return LoadSamples(kind, surface, kind);
}

int Main(const std::string& surface, const std::string& kind, const std::string& path) {
  const std::optional<Samples> samples = Make(surface, kind);
  if (!samples.has_value()) {
    std::fprintf(stderr, "\"%s\" is no file, nor a way to spread samples\n", kind.c_str());
    return 2;
  }
  const absl::Status status = curv::SaveTable(ToTable(*samples), path);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}

}  // namespace
}  // namespace curvd::bench

int main(int argc, char** argv) {
  if (argc == 4) return curvd::bench::Main(argv[1], argv[2], argv[3]);
  std::fprintf(stderr, "usage: paper_cloud SURFACE even|thinned|falling|random|scanned|FILE OUT\n");
  return 2;
}
