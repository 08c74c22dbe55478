#include <charconv>
#include <string>
#include <variant>

#include "client/io/point_status.h"
#include "client/io/writers.h"

namespace curv {
namespace {

constexpr size_t kBlockBytes = 1 << 20;

template <typename T>
void AppendNumber(T value, std::string& out) {
  char digits[32];
  const std::to_chars_result result = std::to_chars(digits, digits + sizeof(digits), value);
  out.append(digits, result.ptr);
}

void AppendValue(const Column& column, bool is_status, size_t row, std::string& out) {
  if (is_status) {
    out.append(StatusWord(std::get<std::vector<uint8_t>>(column.values)[row]));
  } else {
    std::visit([&](const auto& values) { AppendNumber(values[row], out); }, column.values);
  }
}

}  // namespace

absl::Status WriteCsv(const PointTable& table, AtomicFile& file) {
  std::string block;
  for (const Column& column : table.columns()) {
    if (!block.empty()) block += ',';
    block += HeaderName(column.name);
  }
  block += '\n';
  for (size_t row = 0; row < table.size(); ++row) {
    bool first = true;
    for (const Column& column : table.columns()) {
      if (!first) block += ',';
      first = false;
      AppendValue(column, column.name == "status" && column.kind() == ScalarKind::kUint8, row, block);
    }
    block += '\n';
    if (block.size() < kBlockBytes) continue;
    if (absl::Status status = file.Append(block); !status.ok()) return status;
    block.clear();
  }
  return file.Append(block);
}

}  // namespace curv
