#include <string>

#include "client/io/names/column_names.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {

std::string CsvHead(const PointTable& like, uint64_t /*rows*/) {
  std::string header;
  for (const std::string& name : HeaderNames(like, HeaderName)) {
    if (!header.empty()) header += ',';
    header += name;
  }
  return header + '\n';
}

absl::Status WriteCsv(const PointTable& table, ByteSink& file) {
  if (absl::Status status = file.Append(CsvHead(table, table.size())); !status.ok()) return status;
  return AppendTextRows(table, ',', /*status_words=*/true, file);
}

}  // namespace curv
