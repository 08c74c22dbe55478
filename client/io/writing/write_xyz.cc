#include <string>

#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {

std::string XyzHead(const PointTable& like, uint64_t /*rows*/) {
  std::string header = "#";
  for (const Column& column : like.columns()) header += ' ' + HeaderName(column.name);
  return header + '\n';
}

absl::Status WriteXyz(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(XyzHead(table, table.size())); !status.ok()) return status;
  return AppendTextRows(table, ' ', /*status_words=*/false, file);
}

}  // namespace curv
