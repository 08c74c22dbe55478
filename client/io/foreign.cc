#include <string>

#include "absl/status/status.h"
#include "client/io/formats.h"

namespace curv {

absl::StatusOr<PointTable> ReadE57(std::string_view bytes) {
  constexpr std::string_view kSignature = "ASTM-E57";
  if (bytes.substr(0, kSignature.size()) != kSignature) {
    return absl::InvalidArgumentError("the file does not start with \"ASTM-E57\": it is no E57 file");
  }
  return absl::InvalidArgumentError(
      "curv does not read E57. Convert the file first, with \"pdal translate in.e57 out.las\" or, in CloudCompare, by "
      "saving it as PLY");
}

}  // namespace curv
