#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/formats.h"
#include "client/io/text.h"

namespace curv {
namespace {

using Triple = std::array<double, 3>;

class ObjParser {
 public:
  absl::StatusOr<PointTable> Parse(std::string_view bytes) {
    LineReader lines(bytes);
    std::string joined;
    for (std::string_view line; lines.Next(line);) {
      number_ = lines.number();
      // A backslash at its end has a line go on in the next one.
      if (line.ends_with('\\')) {
        joined.clear();
        bool goes_on = true;
        while (goes_on) {
          goes_on = line.ends_with('\\');
          joined.append(line.substr(0, line.size() - (goes_on ? 1 : 0))).append(" ");
          goes_on = goes_on && lines.Next(line);
        }
        line = joined;
      }
      const std::string_view keyword = NextField(line);
      absl::Status status;
      if (keyword == "v") {
        status = ReadVertex(line);
      } else if (keyword == "vn") {
        status = ReadNormal(line);
      } else if (keyword == "f" || keyword == "p" || keyword == "l") {
        status = ReadCorners(line);
      }
      if (!status.ok()) return status;
    }
    return Finish();
  }

 private:
  absl::Status Error(const std::string& problem) const {
    return absl::InvalidArgumentError(absl::StrCat("line ", number_, ": ", problem));
  }

  absl::Status ReadTriple(const char* keyword, std::string_view& line, std::vector<Triple>& triples) {
    Triple triple;
    for (double& value : triple) {
      const std::string_view field = NextField(line);
      if (!ParseNumber(field, value)) {
        return Error(absl::StrCat(keyword, " needs three numbers, found ", Quoted(field)));
      }
    }
    triples.push_back(triple);
    return absl::OkStatus();
  }

  // The next field; empty also where a comment begins.
  static std::string_view NextOf(std::string_view& line) {
    const std::string_view field = NextField(line);
    return field.starts_with('#') ? std::string_view() : field;
  }

  // x y z, then nothing, a weight w, or a color.
  absl::Status ReadVertex(std::string_view line) {
    if (absl::Status status = ReadTriple("v", line, vertices_); !status.ok()) return status;
    std::array<double, 4> more;
    size_t count = 0;
    for (std::string_view field; count < more.size() && !(field = NextOf(line)).empty(); ++count) {
      if (!ParseNumber(field, more[count])) {
        return Error(absl::StrCat("v has ", Quoted(field), " after x y z: expected a color r g b, or a weight w"));
      }
    }
    if (count == 2 || count == 4) {
      return Error(absl::StrCat("v has ", count, count == 4 ? " or more" : "",
                                " numbers after x y z: expected a color r g b, or a weight w"));
    }
    if (count == 3) colors_.push_back({more[0], more[1], more[2]});
    return absl::OkStatus();
  }

  absl::Status ReadNormal(std::string_view line) {
    if (absl::Status status = ReadTriple("vn", line, normals_); !status.ok()) return status;
    const std::string_view more = NextOf(line);
    return more.empty() ? absl::OkStatus() : Error(absl::StrCat("vn has ", Quoted(more), " after its three numbers"));
  }

  // Resolves a reference: from 1, or from the end if negative. False if it refers to nothing so far.
  static bool Resolve(int64_t reference, size_t count, size_t& index) {
    const int64_t size = static_cast<int64_t>(count);
    if (reference < 0) reference += size + 1;
    if (reference < 1 || reference > size) return false;
    index = static_cast<size_t>(reference - 1);
    return true;
  }

  absl::Status ReadCorners(std::string_view line) {
    for (std::string_view corner; !(corner = NextField(line)).empty();) {
      const size_t last = corner.rfind('/');
      if (last == std::string_view::npos || corner.find('/') == last) continue;  // no normal
      int64_t vertex, normal;
      size_t v, n;
      if (!ParseNumber(corner.substr(0, corner.find('/')), vertex) || !ParseNumber(corner.substr(last + 1), normal)) {
        return Error(absl::StrCat("face corner ", Quoted(corner), ": expected integers, as in 7//7 or 7/1/7"));
      }
      if (!Resolve(vertex, vertices_.size(), v) || !Resolve(normal, normals_.size(), n)) {
        return Error(absl::StrCat("face corner ", Quoted(corner),
                                  " refers to a v or vn that does not exist: there are ", vertices_.size(), " and ",
                                  normals_.size(), " so far"));
      }
      sums_.resize(vertices_.size(), Triple{});
      for (size_t axis = 0; axis < 3; ++axis) sums_[v][axis] += normals_[n][axis];
      paired_ = true;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<PointTable> Finish() {
    if (vertices_.empty() && !normals_.empty()) return Error("the file has vn lines but no v lines");
    PointTable table;
    AddColumns({"x", "y", "z"}, vertices_, table);
    if (paired_) {
      sums_.resize(vertices_.size(), Triple{});
      for (Triple& sum : sums_) MakeUnit(sum);
      AddColumns({"nx", "ny", "nz"}, sums_, table);
    } else if (normals_.size() == vertices_.size()) {
      AddColumns({"nx", "ny", "nz"}, normals_, table);
    } else if (!normals_.empty()) {
      table.notes.push_back(absl::StrCat("left out the normals: ", normals_.size(), " vn lines do not correspond to ",
                                         vertices_.size(), " v lines, and no face pairs them"));
    }
    AddColors(table);
    return table;
  }

  // NaN where a vertex has no normal: no face uses it, or those of its corners cancel.
  static void MakeUnit(Triple& sum) {
    const double length = std::hypot(sum[0], sum[1], sum[2]);
    for (double& component : sum) component /= length;
  }

  // Bytes, as other formats have them, where colors are from 0 to 1 or whole numbers up to 255.
  void AddColors(PointTable& table) {
    if (colors_.empty()) return;
    if (colors_.size() < vertices_.size()) {
      table.notes.push_back(absl::StrCat("left out the colors: ", colors_.size(), " of ", vertices_.size(), " v lines ",
                                         colors_.size() == 1 ? "has" : "have", " one"));
      return;
    }
    bool are_shares = true, are_bytes = true;
    for (const Triple& color : colors_) {
      for (const double value : color) {
        are_shares = are_shares && value >= 0.0 && value <= 1.0;
        are_bytes = are_bytes && value >= 0.0 && value <= 255.0 && value == std::floor(value);
      }
    }
    AddColumns({"red", "green", "blue"}, colors_, table);
    if (!are_shares && !are_bytes) return;
    for (const char* name : {"red", "green", "blue"}) {
      std::vector<uint8_t> bytes;
      for (const double value : std::get<std::vector<double>>(table.Find(name)->values)) {
        bytes.push_back(static_cast<uint8_t>(are_shares ? std::lround(255.0 * value) : std::lround(value)));
      }
      table.Set({name, std::move(bytes)});
    }
  }

  static void AddColumns(const std::array<const char*, 3>& names, const std::vector<Triple>& triples,
                         PointTable& table) {
    for (size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      values.reserve(triples.size());
      for (const Triple& triple : triples) values.push_back(triple[axis]);
      table.Set({names[axis], std::move(values)});
    }
  }

  size_t number_ = 0;
  std::vector<Triple> vertices_;
  std::vector<Triple> normals_;
  std::vector<Triple> colors_;  // of the vertices that have one
  std::vector<Triple> sums_;    // of the corner normals of each vertex
  bool paired_ = false;
};

}  // namespace

absl::StatusOr<PointTable> ReadObj(std::string_view bytes) { return ObjParser().Parse(WithoutByteOrderMark(bytes)); }

}  // namespace curv
