// Feeds any bytes to the reader of a file format; CURV_READER names it.
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "client/io/formats.h"
#include "client/io/oriented_cloud.h"
#include "tests/fuzz/require.h"

namespace {

using curv::Column;
using curv::PointTable;

// LZF makes at most 88 bytes of one, 64-bit integers stay as long, and the shortest text of a double takes two bytes.
#ifndef CURV_MAX_GROWTH
#define CURV_MAX_GROWTH 88
#endif
constexpr size_t kMaxGrowth = CURV_MAX_GROWTH;

void CheckTable(const PointTable& table, size_t file_bytes) {
  size_t bytes = 0;
  std::set<std::string> names;
  for (const Column& column : table.columns()) {
    fuzz::Require(column.size() == table.size(), "all columns of a table are equally long");
    fuzz::Require(names.insert(column.name).second, "no two columns have the same name");
    bytes += column.size() * curv::BytesOf(column.kind());
  }
  fuzz::Require(bytes <= kMaxGrowth * file_bytes, "a table is at most so many times as large as its file");
  for (const std::string& note : table.notes) fuzz::Require(fuzz::IsShowable(note), "notes are printable");
}

void CheckError(const absl::Status& status) {
  fuzz::Require(absl::IsInvalidArgument(status), "errors are INVALID_ARGUMENT");
  const absl::string_view message = status.message();
  fuzz::Require(fuzz::IsShowable({message.data(), message.size()}), "messages are printable");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  const absl::StatusOr<PointTable> table = curv::CURV_READER({reinterpret_cast<const char*>(bytes), size});
  if (!table.ok()) {
    CheckError(table.status());
    return 0;
  }
  CheckTable(*table, size);
  const absl::StatusOr<curv::OrientedCloud> cloud = curv::ExtractCloud(*table);
  if (!cloud.ok()) {
    CheckError(cloud.status());
    return 0;
  }
  std::visit(
      [&](const auto& packed) {
        fuzz::Require(packed.positions.size() == 3 * table->size(), "a cloud has a position for each row");
        fuzz::Require(packed.normals.size() == 3 * table->size(), "a cloud has a normal for each row");
      },
      *cloud);
  return 0;
}
