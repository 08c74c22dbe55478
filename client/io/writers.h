// Declares one writer for each file format that SaveTable offers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "client/io/byte_sink.h"
#include "client/io/point_table.h"

namespace curv {

// Whose names the properties of a PLY file have. CloudCompare keeps what is called scalar_NAME, and drops the rest but
// for positions, normals and colors; MeshLab keeps one scalar, called quality, which is the mean curvature then.
enum class PlyNames { kOwn, kCloudCompare, kMeshLab };

// How a PLY file is written.
struct PlyForm {
  bool ascii = false;  // text in place of binary numbers
  PlyNames names = PlyNames::kOwn;
};

// These append the table to `file`; see SaveTable for the formats. Errors are those of ByteSink::Append.
absl::Status WritePly(const PointTable& table, ByteSink& file, const PlyForm& form = {});
absl::Status WriteCsv(const PointTable& table, ByteSink& file);
absl::Status WritePcd(const PointTable& table, ByteSink& file);
absl::Status WriteAsciiPcd(const PointTable& table, ByteSink& file);
absl::Status WriteXyz(const PointTable& table, ByteSink& file);
absl::Status WriteNpy(const PointTable& table, ByteSink& file);
absl::Status WriteNpz(const PointTable& table, ByteSink& file);
// Also INVALID_ARGUMENT if the table has no finite x, y and z, or more attributes than LAS can describe.
absl::Status WriteLas(const PointTable& table, ByteSink& file);

// What stands before the rows of a file with the columns of `like`, and as many rows; in text it does not tell how
// many.
std::string PlyHead(const PointTable& like, uint64_t rows, const PlyForm& form = {});
std::string CsvHead(const PointTable& like, uint64_t rows);
std::string PcdHead(const PointTable& like, uint64_t rows);
std::string AsciiPcdHead(const PointTable& like, uint64_t rows);
std::string XyzHead(const PointTable& like, uint64_t rows);
std::string NpyHead(const PointTable& like, uint64_t rows);

// Returns `name` with underscores in place of characters that would break a header: blanks, control characters, commas,
// semicolons and double quotes. Letters of other alphabets stay, in UTF-8.
std::string HeaderName(std::string_view name);

}  // namespace curv
