// Reads tables from files and writes them into files, in the format that the extension of the name tells.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/point_table.h"
#include "client/io/writers.h"

namespace curv {

// Extensions that LoadTable and SaveTable know, for help texts.
inline constexpr char kReadableExtensions[] = ".ply .pcd .xyz .pts .xyzn .txt .asc .obj .csv .las .npy .npz";
inline constexpr char kWritableExtensions[] = ".ply .pcd .xyz .csv .las .npy .npz";

// The same for people, who may pack files, and use pipes.
inline constexpr char kReadableFiles[] =
    ".ply .pcd .xyz .pts .xyzn .txt .asc .obj .csv .las .npy .npz, each also with .gz, or - for standard input";
inline constexpr char kWritableFiles[] =
    ".ply .pcd .xyz .csv .las .npy .npz, each also with .gz, or - for standard output";

// The formats that --format can name: the extensions without their dots.
inline constexpr const char* kFormats[] = {"ply", "pcd", "xyz", "csv", "las", "npy", "npz", "obj"};

// Reads a file; upper and lower case extensions are the same. "-" is standard input. `format`, one of kFormats, says
// how to read it, and files whose extension is not known. What gzip has packed is unpacked, whatever its name.
// INVALID_ARGUMENT naming the file if it cannot be read, has no known format, is not what its format says, or holds no
// points.
absl::StatusOr<PointTable> LoadTable(const std::string& path, const std::string& format = "");

// The two halves of LoadTable, for who looks at the bytes in between.
struct FileBytes {
  std::string shown;      // what messages call it
  std::string extension;  // ReadableExtension
  std::string bytes;      // all of it, unpacked
};
absl::StatusOr<FileBytes> LoadBytes(const std::string& path, const std::string& format = "");
// REQUIRES: the file comes from LoadBytes.
absl::StatusOr<PointTable> TableOf(const FileBytes& file);

// The extension by which LoadTable chooses how to read a file: that of its name, without .gz, or of `format`; in lower
// case, with the dot. INVALID_ARGUMENT if it is not known.
absl::StatusOr<std::string> ReadableExtension(const std::string& path, const std::string& format = "");

struct SaveOptions {
  bool ascii = false;               // text in place of binary numbers, in PLY and PCD; refused for LAS, NPY and NPZ
  std::string format{};             // of standard output, and of files whose extension is not known
  PlyNames names = PlyNames::kOwn;  // others than kOwn are refused for other formats than PLY
};

// How SaveTable writes a file of that name.
struct WritableName {
  std::string extension;  // in lower case, with the dot, without .gz
  bool gzip = false;
};
// INVALID_ARGUMENT if SaveTable can write no such file; FAILED_PRECONDITION if it can, but not as the options say.
absl::StatusOr<WritableName> WritableNameOf(const std::string& path, const SaveOptions& options = {});

// Returns whether SaveTable can write a file of that name.
bool IsWritable(const std::string& name);

// INVALID_ARGUMENT if SaveTable could not write such a file: unknown format, or no file can be created there;
// FAILED_PRECONDITION if the format has no such form as the options say. Leaves no trace.
absl::Status CheckWritable(const std::string& path, const SaveOptions& options = {});

// Writes all columns in order, whole or not at all ("-" is standard output), packed with gzip if the name ends in .gz
// after its extension: binary little-endian PLY, or CSV with the columns' names in the
// first line and the shortest digits that read back as the same value. The column `status` of type uint8 is a word in
// CSV, a number in PLY (whose header explains it). Blanks, commas and quotes in names become '_'. LAS has 32-bit
// coordinates on a lattice; that of the file that the table comes from is kept, and all else that it said.
//
// Text files hold a line a point, in the shortest digits that read back as the same value; CSV has the columns' names
// in its first line, XYZ in a comment.
absl::Status SaveTable(const PointTable& table, const std::string& path, const SaveOptions& options = {});

}  // namespace curv
