#include "client/io/blocks/table_blocks.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/archive/inflate.h"
#include "client/io/blocks/input_file.h"
#include "client/io/blocks/row_layout.h"
#include "client/io/formats.h"
#include "client/io/table_file.h"
#include "client/io/text.h"

namespace curv {
namespace {

using Reader = absl::StatusOr<PointTable> (*)(std::string_view);
using LinesReader = absl::StatusOr<PointTable> (*)(std::string_view, std::string_view, LinesBefore&);

// The lines at the start of a text file that say what the columns are.
struct TextStart {
  std::string line;       // of names, or the comment before the first point
  uint64_t bytes = 0;     // of all of them, after which others follow
  size_t line_count = 0;  // of all of them
  std::optional<uint64_t> declared;
};

absl::Status Named(const std::string& path, const absl::Status& status) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", status.message()));
}

// Rows of equal size, behind a start that is made for each block.
class RowBlocks : public TableBlocks {
 public:
  RowBlocks(InputFile file, RowLayout layout, Reader reader, uint64_t block_bytes)
      : file_(std::move(file)),
        layout_(std::move(layout)),
        reader_(reader),
        block_rows_(std::max<uint64_t>(block_bytes / layout_.row_bytes, 1)) {}

  absl::StatusOr<PointTable> Next() override {
    const uint64_t rows = std::min(block_rows_, layout_.rows - next_row_);
    if (rows == 0) return PointTable();
    const uint64_t bytes_left = file_.stamp().bytes - std::min(file_.stamp().bytes, layout_.rows_at);
    if (bytes_left / layout_.row_bytes < layout_.rows) {
      return absl::InvalidArgumentError(
          absl::StrCat(file_.path(), ": byte ", layout_.rows_at, ": the file ends too early: ", layout_.rows,
                       " points of ", layout_.row_bytes, " bytes are declared, ", bytes_left, " bytes are left"));
    }
    std::string bytes = layout_.start(rows);
    const size_t start = bytes.size();
    bytes.resize(start + rows * layout_.row_bytes);
    absl::Status status =
        file_.ReadAll(layout_.rows_at + next_row_ * layout_.row_bytes, rows * layout_.row_bytes, bytes.data() + start);
    if (!status.ok()) return status;
    absl::StatusOr<PointTable> table = reader_(bytes);
    if (!table.ok()) return Named(file_.path(), table.status());
    next_row_ += rows;
    return table;
  }

  bool is_whole() const override { return false; }

 private:
  const InputFile file_;
  const RowLayout layout_;
  const Reader reader_;
  const uint64_t block_rows_;
  uint64_t next_row_ = 0;
};

// Lines of text, behind those at the start of the file.
class LineBlocks : public TableBlocks {
 public:
  LineBlocks(InputFile file, TextStart start, LinesReader reader, uint64_t block_bytes)
      : file_(std::move(file)),
        start_(std::move(start)),
        reader_(reader),
        block_bytes_(block_bytes),
        at_(start_.bytes),
        before_{.count = start_.line_count, .words = {}} {}

  absl::StatusOr<PointTable> Next() override {
    while (at_ < file_.stamp().bytes) {
      absl::StatusOr<std::string> lines = ReadLines();
      if (!lines.ok()) return lines.status();
      at_ += lines->size();
      absl::StatusOr<PointTable> table = reader_(start_.line, *lines, before_);
      if (!table.ok()) return Named(file_.path(), table.status());
      rows_ += table->size();
      if (table->size() > 0) return table;  // a block may hold nothing but comments
    }
    if (start_.declared.has_value() && *start_.declared != rows_) {
      return absl::InvalidArgumentError(absl::StrCat(file_.path(), ": the first line declares ", *start_.declared,
                                                     " points, the file holds ", rows_));
    }
    return PointTable();
  }

  bool is_whole() const override { return false; }

 private:
  // Whole lines, from at_ on.
  absl::StatusOr<std::string> ReadLines() const {
    for (uint64_t bytes = block_bytes_;; bytes *= 2) {
      absl::StatusOr<std::string> read = file_.Read(at_, bytes);
      if (!read.ok()) return read;
      if (at_ + read->size() >= file_.stamp().bytes) return read;
      if (read->empty()) return file_.ReadAll(at_, 1, read->data());  // it has become shorter
      size_t end = read->rfind('\n');
      if (end == std::string::npos) end = read->rfind('\r');
      if (end == std::string::npos) continue;
      read->resize(end + 1);
      return read;
    }
  }

  const InputFile file_;
  const TextStart start_;
  const LinesReader reader_;
  const uint64_t block_bytes_;
  uint64_t at_;
  uint64_t rows_ = 0;
  LinesBefore before_;
};

class WholeFile : public TableBlocks {
 public:
  WholeFile(std::string path, std::string format) : path_(std::move(path)), format_(std::move(format)) {}

  absl::StatusOr<PointTable> Next() override {
    if (std::exchange(was_read_, true)) return PointTable();
    return LoadTable(path_, format_);
  }

  bool is_whole() const override { return true; }

 private:
  const std::string path_;
  const std::string format_;
  bool was_read_ = false;
};

// The comment before the first point, and the number of points if it is declared. See ReadXyz.
TextStart XyzStart(std::string_view text) {
  TextStart found;
  LineReader lines(WithoutByteOrderMark(text));
  found.bytes = text.size() - lines.rest().size();
  for (std::string_view line; lines.Next(line);) {
    std::string_view rest = line;
    const std::string_view first = NextField(rest);
    uint64_t value = 0;
    if (first.starts_with('#') || first.starts_with("//")) {
      found.line = std::string(line);
    } else if (!first.empty() && NextField(rest).empty() && !found.declared && ParseNumber(first, value)) {
      found.declared = value;
    } else if (!first.empty()) {
      break;
    }
    found.bytes = text.size() - lines.rest().size();
    found.line_count = lines.number();
  }
  return found;
}

TextStart CsvStart(std::string_view text) {
  LineReader lines(text);
  std::string_view line;
  if (!lines.Next(line)) return {};
  return {std::string(line), text.size() - lines.rest().size(), 1, std::nullopt};
}

// Files of other formats are read as a whole.
std::unique_ptr<TableBlocks> OpenBlocks(InputFile& file, const std::string& extension, const std::string& start,
                                        uint64_t block_bytes) {
  const auto rows = [&](std::optional<RowLayout> layout, Reader reader) -> std::unique_ptr<TableBlocks> {
    if (!layout.has_value() || layout->rows == 0) return nullptr;
    return std::make_unique<RowBlocks>(std::move(file), *std::move(layout), reader, block_bytes);
  };
  const auto lines = [&](TextStart found, LinesReader reader) {
    return std::make_unique<LineBlocks>(std::move(file), std::move(found), reader, block_bytes);
  };
  if (extension == ".ply") return rows(PlyLayout(start), ReadPly);
  if (extension == ".pcd") return rows(PcdLayout(start), ReadPcd);
  if (extension == ".npy") return rows(NpyLayout(start), ReadNpy);
  if (extension == ".las") return rows(LasLayout(start), ReadLas);
  if (extension == ".csv") return lines(CsvStart(start), ReadCsvBlock);
  for (const char* text : {".xyz", ".pts", ".xyzn", ".txt", ".asc"}) {
    if (extension == text) return lines(XyzStart(start), ReadXyzBlock);
  }
  return nullptr;
}

}  // namespace

absl::StatusOr<std::unique_ptr<TableBlocks>> TableBlocks::Open(const std::string& path, const std::string& format,
                                                               uint64_t block_bytes, uint64_t most_bytes) {
  const absl::StatusOr<std::string> extension = ReadableExtension(path, format);
  if (!extension.ok()) return extension.status();
  if (path == "-") {
    return absl::InvalidArgumentError("standard input cannot be read twice: write it into a file first");
  }
  absl::StatusOr<InputFile> file = InputFile::Open(path);
  if (!file.ok()) return file.status();
  absl::StatusOr<std::string> start = file->Read(0, kLayoutBytes);
  if (start.ok() && *extension == ".las" && LasPointsAt(*start) > start->size()) {
    start = file->Read(0, std::min(LasPointsAt(*start), most_bytes));
  }
  if (!start.ok()) return start.status();
  const uint64_t bytes = file->stamp().bytes;
  if (!IsGzip(*start)) {
    if (std::unique_ptr<TableBlocks> blocks = OpenBlocks(*file, *extension, *start, block_bytes)) return blocks;
  }
  if (bytes <= most_bytes) return std::make_unique<WholeFile>(path, format);
  return absl::ResourceExhaustedError(absl::StrCat(
      path, ": it would have to be read as a whole, and has ", bytes, " bytes, of which the memory bound allows ",
      most_bytes, ". Raise --memory, or convert it to binary PLY, LAS, NPY or text without gzip"));
}

}  // namespace curv
