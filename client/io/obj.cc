#include <array>
#include <string>
#include <utility>
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
        status = ReadTriple("v", line, vertices_);
      } else if (keyword == "vn") {
        status = ReadTriple("vn", line, normals_);
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

  absl::Status ReadTriple(const char* keyword, std::string_view line, std::vector<Triple>& triples) {
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
      AddColumns({"nx", "ny", "nz"}, sums_, table);
    } else if (normals_.size() == vertices_.size()) {
      AddColumns({"nx", "ny", "nz"}, normals_, table);
    } else if (!normals_.empty()) {
      table.notes.push_back(absl::StrCat("left out the normals: ", normals_.size(), " vn lines do not correspond to ",
                                         vertices_.size(), " v lines, and no face pairs them"));
    }
    return table;
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
  std::vector<Triple> sums_;  // of the corner normals of each vertex
  bool paired_ = false;
};

}  // namespace

absl::StatusOr<PointTable> ReadObj(std::string_view bytes) { return ObjParser().Parse(WithoutByteOrderMark(bytes)); }

}  // namespace curv
