#include "client/io/table_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <new>
#include <optional>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/archive/gzip_sink.h"
#include "client/io/archive/inflate.h"
#include "client/io/atomic_file.h"
#include "client/io/formats.h"
#include "client/io/memory/machine_memory.h"
#include "client/io/writers.h"

namespace curv {
namespace {

// With the dot, in lower case; "" if there is none.
std::string ExtensionOf(const std::string& path) {
  const size_t name = path.find_last_of('/') + 1;
  const size_t dot = path.rfind('.');
  return dot == std::string::npos || dot < name ? "" : absl::AsciiStrToLower(path.substr(dot));
}

// Names an extension that no format has among those that are read, or written.
absl::Status ExtensionError(const std::string& path, const std::string& extension, const char* allowed,
                            const char* what) {
  return absl::InvalidArgumentError(absl::StrCat(
      path, extension.empty() ? ": there is no extension" : absl::StrCat(": the extension \"", extension, "\" ", what),
      ": it must be one of ", allowed));
}

constexpr char kStandard[] = "-";

absl::Status IsDirectoryError(const std::string& path, const char* what) {
  return absl::InvalidArgumentError(absl::StrCat(path, " is a directory: ", what));
}

bool IsDirectory(const std::string& path) {
  struct stat status {};
  return path != kStandard && stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

struct NamedFormat {
  std::string extension;  // with the dot, in lower case
  bool gzip = false;      // whether the name says that gzip has packed, or is to pack, the file
};

// The format that a name tells, or, where it tells none that is in `known`, the format that was asked for.
absl::StatusOr<NamedFormat> FormatOfName(const std::string& path, const std::string& asked, const char* known) {
  constexpr char kGzip[] = ".gz";
  NamedFormat named{.extension = ExtensionOf(path)};
  if (named.extension == kGzip) named = {ExtensionOf(path.substr(0, path.size() - (sizeof(kGzip) - 1))), true};
  const bool is_known = !named.extension.empty() && absl::StrContains(absl::StrCat(known, " "), named.extension + " ");
  if (!asked.empty() && !is_known) named.extension = "." + asked;
  if (path == kStandard && asked.empty()) {
    return absl::InvalidArgumentError("the name - does not tell a format: say --format=ply, or another");
  }
  return named;
}

using Reader = absl::StatusOr<PointTable> (*)(std::string_view);
using Writer = std::function<absl::Status(const PointTable&, ByteSink&)>;

struct Format {
  Reader read;
  const char* points;  // what a file with points has, for the message about one without
};

std::optional<Format> FormatOf(const std::string& extension) {
  if (extension == ".ply") return Format{ReadPly, "rows of the element vertex"};
  if (extension == ".pcd") return Format{ReadPcd, "POINTS of 1 or more, and as many rows"};
  if (extension == ".obj") return Format{ReadObj, "v lines"};
  if (extension == ".csv") return Format{ReadCsv, "lines of values after the line with the columns' names"};
  if (extension == ".las" || extension == ".laz") return Format{ReadLas, "point data records"};
  if (extension == ".npy") return Format{ReadNpy, "an array of shape (N, 3) or (N, 6), N not 0"};
  if (extension == ".npz") return Format{ReadNpz, "arrays of N elements, N not 0"};
  if (extension == ".e57") return Format{ReadE57, "points"};
  for (const char* text : {".xyz", ".pts", ".xyzn", ".txt", ".asc"}) {
    if (extension == text) return Format{ReadXyz, "lines of x y z nx ny nz"};
  }
  return std::nullopt;
}

Writer WriterFor(const std::string& extension, const SaveOptions& options) {
  if (extension == ".ply") {
    const PlyForm form{.ascii = options.ascii, .names = options.names};
    return [form](const PointTable& table, ByteSink& file) { return WritePly(table, file, form); };
  }
  if (extension == ".pcd") return options.ascii ? WriteAsciiPcd : WritePcd;
  if (extension == ".xyz") return WriteXyz;
  if (extension == ".csv") return WriteCsv;
  if (extension == ".npy") return WriteNpy;
  if (extension == ".npz") return WriteNpz;
  if (extension == ".las") return WriteLas;
  return nullptr;
}

// Whether a format has the form that is asked for. What is text in any case, as CSV, is text with --ascii too.
absl::Status CheckForm(const std::string& path, const std::string& extension, const SaveOptions& options) {
  const auto shown = [&path] { return path == kStandard ? "standard output" : path; };
  if (options.names != PlyNames::kOwn && extension != ".ply") {
    return absl::FailedPreconditionError(
        absl::StrCat(shown(), ": --names says what the properties of PLY are called: the output must be .ply"));
  }
  const bool is_binary = extension == ".las" || extension == ".npy" || extension == ".npz";
  if (!options.ascii || !is_binary) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      shown(), ": --ascii: ", extension, " has no form of text: the output must be .ply, .pcd, .xyz or .csv"));
}

struct NamedWriter {
  Writer write;
  bool gzip;
};

absl::StatusOr<NamedWriter> FindWriter(const std::string& path, const SaveOptions& options) {
  if (IsDirectory(path)) return IsDirectoryError(path, "the output must be a file");
  const absl::StatusOr<NamedFormat> named = FormatOfName(path, options.format, kWritableExtensions);
  if (!named.ok()) return named.status();
  const Writer writer = WriterFor(named->extension, options);
  if (writer == nullptr) return ExtensionError(path, named->extension, kWritableExtensions, "cannot be written");
  if (absl::Status status = CheckForm(path, named->extension, options); !status.ok()) return status;
  return NamedWriter{writer, named->gzip};
}

// Closes the descriptor at the end of a scope.
class OpenFile {
 public:
  explicit OpenFile(const std::string& path)
      : descriptor_(path == kStandard ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                      : open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

// By errno.
absl::Status CannotRead(const std::string& path) {
  const std::string shown = path == kStandard ? "standard input" : path;
  return absl::InvalidArgumentError(absl::StrCat("cannot read ", shown, ": ", std::strerror(errno)));
}

// The most bytes of a file that are kept in memory: its table takes about as much again.
uint64_t MostFileBytes() { return UsableMemory() / 2; }
// The same for what comes without its size, in memory that grows by copies. Some of it never ends.
uint64_t MostStreamBytes() { return UsableMemory() / 4; }

// Reads to the end, so that pipes work too. Not mapped: a mapped file that another program shortens kills the reader.
absl::StatusOr<std::string> ReadBytes(const std::string& path) {
  constexpr size_t kFirstRead = 1 << 20;
  const OpenFile file(path);
  if (file.descriptor() < 0) return CannotRead(path);
  struct stat status {};
  if (fstat(file.descriptor(), &status) != 0) return CannotRead(path);
  const uint64_t most = S_ISREG(status.st_mode) ? MostFileBytes() : MostStreamBytes();
  const auto too_large = [&] {
    return absl::InvalidArgumentError(absl::StrCat("cannot read ", path == kStandard ? "standard input" : path,
                                                   ": it has more than ", most, " bytes, too many for the ",
                                                   UsableMemory(), " bytes of memory that curv may use"));
  };
  if (S_ISREG(status.st_mode) && static_cast<uint64_t>(status.st_size) > most) return too_large();
  // One byte more than the file has, to meet its end without growing.
  std::string bytes(S_ISREG(status.st_mode) ? static_cast<size_t>(status.st_size) + 1 : kFirstRead, '\0');
  size_t size = 0;
  while (true) {
    const ssize_t got = read(file.descriptor(), bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return CannotRead(path);
    if (got == 0) break;
    size += static_cast<size_t>(got);
    if (size > most) return too_large();
    if (size == bytes.size()) bytes.resize(std::min<uint64_t>(2 * size, most + 1));
  }
  bytes.resize(size);
  return bytes;
}

absl::Status NoMemoryFor(const std::string& shown) {
  return absl::InvalidArgumentError(absl::StrCat("cannot read ", shown, ": there is not enough memory for it"));
}

}  // namespace

absl::StatusOr<std::string> ReadableExtension(const std::string& path, const std::string& format) {
  if (IsDirectory(path)) return IsDirectoryError(path, "name the files in it");
  const absl::StatusOr<NamedFormat> named = FormatOfName(path, format, kReadableExtensions);
  if (!named.ok()) return named.status();
  if (FormatOf(named->extension)) return named->extension;
  // Without the file, no format would help.
  if (access(path.c_str(), F_OK) != 0) return CannotRead(path);
  const absl::Status error = ExtensionError(path, named->extension, kReadableExtensions, "is not known");
  return absl::InvalidArgumentError(absl::StrCat(error.message(), "; or say --format=ply, or another"));
}

absl::StatusOr<FileBytes> LoadBytes(const std::string& path, const std::string& format) {
  absl::StatusOr<std::string> extension = ReadableExtension(path, format);
  if (!extension.ok()) return extension.status();
  FileBytes file{.shown = path == kStandard ? "standard input" : path, .extension = *std::move(extension), .bytes = {}};
  try {
    absl::StatusOr<std::string> bytes = ReadBytes(path);
    if (bytes.ok() && IsGzip(*bytes)) {
      bytes = Gunzip(*bytes, MostStreamBytes());
      if (!bytes.ok()) return absl::InvalidArgumentError(absl::StrCat(file.shown, ": ", bytes.status().message()));
    }
    if (!bytes.ok()) return bytes.status();
    file.bytes = *std::move(bytes);
    return file;
  } catch (const std::bad_alloc&) {
    return NoMemoryFor(file.shown);
  }
}

absl::StatusOr<PointTable> TableOf(const FileBytes& file) {
  const std::optional<Format> reader = FormatOf(file.extension);
  try {
    absl::StatusOr<PointTable> table = reader->read(file.bytes);
    if (!table.ok()) return absl::InvalidArgumentError(absl::StrCat(file.shown, ": ", table.status().message()));
    if (table->size() == 0) {
      return absl::InvalidArgumentError(absl::StrCat(file.shown, ": the file holds no points",
                                                     file.bytes.empty() ? ", it is empty" : "", ": expected ",
                                                     reader->points));
    }
    return table;
  } catch (const std::bad_alloc&) {
    return NoMemoryFor(file.shown);
  }
}

absl::StatusOr<PointTable> LoadTable(const std::string& path, const std::string& format) {
  const absl::StatusOr<FileBytes> file = LoadBytes(path, format);
  if (!file.ok()) return file.status();
  return TableOf(*file);
}

absl::StatusOr<WritableName> WritableNameOf(const std::string& path, const SaveOptions& options) {
  if (absl::Status status = FindWriter(path, options).status(); !status.ok()) return status;
  const absl::StatusOr<NamedFormat> named = FormatOfName(path, options.format, kWritableExtensions);
  return WritableName{named->extension, named->gzip};
}

bool IsWritable(const std::string& name) { return FindWriter(name, {}).ok(); }

absl::Status CheckWritable(const std::string& path, const SaveOptions& options) {
  if (absl::Status status = FindWriter(path, options).status(); !status.ok()) return status;
  return AtomicFile::Check(path);
}

absl::Status SaveTable(const PointTable& table, const std::string& path, const SaveOptions& options) {
  const absl::StatusOr<NamedWriter> writer = FindWriter(path, options);
  if (!writer.ok()) return writer.status();
  absl::StatusOr<AtomicFile> file = AtomicFile::Create(path);
  if (!file.ok()) return file.status();
  if (!writer->gzip) {
    if (absl::Status status = writer->write(table, *file); !status.ok()) return status;
    return file->Commit();
  }
  GzipSink packed(*file);
  if (absl::Status status = writer->write(table, packed); !status.ok()) return status;
  if (absl::Status status = packed.Finish(); !status.ok()) return status;
  return file->Commit();
}

}  // namespace curv
