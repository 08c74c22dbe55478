// Declares one reader for each file format that holds point clouds; LoadTable (table_file.h) picks among them.
//
// Each takes the bytes of a whole file and returns its points, which may be none. Memory stays within a constant factor
// of the file's size (LZF: of what it can decompress to). INVALID_ARGUMENT for a file that is not what it should be;
// the message names the line or byte, what was found and what was expected.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/io/point_table.h"

namespace curv {

// Reads PLY 1.0, ascii, binary_little_endian or binary_big_endian: the properties of the element `vertex`, in their
// types. Other elements are skipped. List properties of vertices have no place in a table: they are left out with a
// note. scalar_NAME, as CloudCompare writes, becomes NAME, unless there is another property of that name.
absl::StatusOr<PointTable> ReadPly(std::string_view bytes);

// Reads PCD 0.5 to 0.7, ascii, binary or binary_compressed. normal_x normal_y normal_z become nx ny nz. Fields with a
// COUNT other than 1 and padding ("_") are left out, with a note; 64-bit integers become doubles, with a note
// if one is rounded. Packed colors, rgb or
// rgba, become red green blue and alpha. A VIEWPOINT other than 0 0 0 becomes that of the table; its rotation, and
// WIDTH and HEIGHT, its PointTable::pcd.
absl::StatusOr<PointTable> ReadPcd(std::string_view bytes);

// Reads text with one point a line: x y z, then nx ny nz, then any further columns, which are named column7, column8
// and so on. Fields are separated by blanks, commas or semicolons. Lines that start with # or // are comments; a first
// line of one integer is the number of points. Six columns whose last three are integers from 0 to 255, some above 1,
// hold colors: they become red green blue; other columns 4 to 6 are normals only if they hold vectors of length 1, to a
// tenth, and are column4 and so on otherwise, with a note. Where the comment right before the first point, or before
// the number of points, starts with x y z and has a word for each column, these are the columns' names (X Y Z Nx Ny Nz
// in either case).
absl::StatusOr<PointTable> ReadXyz(std::string_view bytes);

// Reads the v and vn lines of OBJ. Where faces pair vertices with normals (f v//vn or v/vt/vn), a vertex gets the unit
// vector along the sum of its corners' normals, NaN if it has none; otherwise vertices and normals correspond in order,
// if there are as many. Colors after x y z become red green blue, of bytes if they are from 0 to 1 or whole numbers up
// to 255; a number w there, and everything else, is left out.
absl::StatusOr<PointTable> ReadObj(std::string_view bytes);

// Reads comma-separated values under a line with the columns' names, as WriteCsv makes them: doubles, save `status`,
// which is a word. If that line has no comma, semicolons separate them, or tabs if it has none of these either.
// Cells and names may be in quotes, and hold separators then. Empty cells are NaN, but errors in x y z nx ny nz. A
// `status` with values that are no bytes is of doubles. A column whose first value is a word is left out, with a note.
// A first column without a name is the index; the line of names may be a comment (# or //), and end with a separator,
// as others may then.
absl::StatusOr<PointTable> ReadCsv(std::string_view bytes);

// What the lines of a text file tell of those that follow, where it is read block by block.
struct LinesBefore {
  size_t count = 0;             // of the file, so that messages name lines by their numbers in it
  std::set<std::string> words;  // columns of CSV that hold words, also where a block of them begins with a number
};
// The same of `lines`, whole lines that follow those of `before`, to which they are added. `start` is the line of
// names, or the comment in its place, without its end.
absl::StatusOr<PointTable> ReadXyzBlock(std::string_view start, std::string_view lines, LinesBefore& before);
absl::StatusOr<PointTable> ReadCsvBlock(std::string_view start, std::string_view lines, LinesBefore& before);

// Reads LAS 1.0 to 1.4, point formats 0 to 10 (ASPRS LAS 1.4 R15): x y z in doubles, every attribute of the format, and
// the extra ones under their names; normal_x normal_y normal_z become nx ny nz. What else the file says is kept in
// PointTable::las. Compressed points (LAZ, COPC) are read where the build found lazperf, and refused with a remedy
// elsewhere.
absl::StatusOr<PointTable> ReadLas(std::string_view bytes);

// Reads an array that numpy has saved: (N, 3), x y z; (N, 6), with nx ny nz; wider ones, whose further columns are
// named column7 and so on (columns 4 to 6 as in text, but that zeros are normals); or a structured one of shape (N,),
// whose fields are the columns (a field of three scalars is NAMEx NAMEy NAMEz, of `positions` x y z, of `normals` nx ny
// nz). Floats and integers of either byte order, C or Fortran order; integers of 64 bits become doubles.
absl::StatusOr<PointTable> ReadNpy(std::string_view bytes);

// Reads arrays that numpy has saved together, stored or deflated: each of shape (N,) is a column, each of shape (N, 3)
// three, named as above; positions may be wider. One must be positions, points or xyz, or all of x, y and z. Others
// than of N points are left out, with a note.
absl::StatusOr<PointTable> ReadNpz(std::string_view bytes);

// Refuses E57 with a remedy.
absl::StatusOr<PointTable> ReadE57(std::string_view bytes);

}  // namespace curv
