#include "client/io/writing/table_stream.h"

#include <functional>
#include <optional>
#include <utility>

#include "client/io/archive/gzip_sink.h"
#include "client/io/atomic_file.h"
#include "client/io/writers.h"
#include "client/io/writing/rows.h"

namespace curv {
namespace {

struct StreamedFormat {
  std::function<std::string(const PointTable& like, uint64_t rows)> head;
  absl::Status (*append)(const PointTable& table, ByteSink& file);
};

absl::Status AppendBlanked(const PointTable& table, ByteSink& file) {
  return AppendTextRows(table, ' ', /*status_words=*/false, file);
}

absl::Status AppendCommas(const PointTable& table, ByteSink& file) {
  return AppendTextRows(table, ',', /*status_words=*/true, file);
}

std::optional<StreamedFormat> FormatFor(const std::string& extension, const SaveOptions& options) {
  const bool ascii = options.ascii;
  if (extension == ".ply") {
    const PlyForm form{.ascii = ascii, .names = options.names};
    return StreamedFormat{[form](const PointTable& like, uint64_t rows) { return PlyHead(like, rows, form); },
                          ascii ? AppendBlanked : AppendBinaryRows};
  }
  if (extension == ".pcd") {
    return ascii ? StreamedFormat{AsciiPcdHead, AppendAsciiPcdRows} : StreamedFormat{PcdHead, AppendPcdRows};
  }
  if (extension == ".xyz") return StreamedFormat{XyzHead, AppendXyzRows};
  if (extension == ".csv") return StreamedFormat{CsvHead, AppendCommas};
  if (extension == ".npy") return StreamedFormat{NpyHead, AppendBinaryRows};
  return std::nullopt;
}

class FileStream : public TableStream {
 public:
  FileStream(AtomicFile file, StreamedFormat format, bool gzip) : file_(std::move(file)), format_(std::move(format)) {
    if (gzip) packed_.emplace(file_);
  }

  absl::Status Start(const PointTable& like, uint64_t rows) { return sink().Append(format_.head(like, rows)); }
  absl::Status Append(const PointTable& table) override { return format_.append(table, sink()); }

  absl::Status Commit() override {
    if (packed_.has_value()) {
      if (absl::Status status = packed_->Finish(); !status.ok()) return status;
    }
    return file_.Commit();
  }

 private:
  ByteSink& sink() { return packed_.has_value() ? static_cast<ByteSink&>(*packed_) : file_; }

  AtomicFile file_;
  std::optional<GzipSink> packed_;  // writes into the file
  const StreamedFormat format_;
};

}  // namespace

bool TableStream::CanWrite(const std::string& path, const SaveOptions& options) {
  const absl::StatusOr<WritableName> name = WritableNameOf(path, options);
  return name.ok() && FormatFor(name->extension, options).has_value();
}

absl::StatusOr<std::unique_ptr<TableStream>> TableStream::Create(const std::string& path, const SaveOptions& options,
                                                                 const PointTable& like, uint64_t rows) {
  const absl::StatusOr<WritableName> name = WritableNameOf(path, options);
  if (!name.ok()) return name.status();
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  auto stream = std::make_unique<FileStream>(*std::move(file), *FormatFor(name->extension, options), name->gzip);
  if (absl::Status status = stream->Start(like, rows); !status.ok()) return status;
  return stream;
}

}  // namespace curv
