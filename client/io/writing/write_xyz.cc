#include <string>

#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {

absl::Status WriteXyz(const PointTable& table, ByteSink& file) {
  std::string header = "#";
  for (const Column& column : table.columns()) header += ' ' + HeaderName(column.name);
  if (absl::Status status = file.Append(header + '\n'); !status.ok()) return status;
  return AppendTextRows(table, ' ', /*status_words=*/false, file);
}

}  // namespace curv
