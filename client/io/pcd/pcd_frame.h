// What a PCD file says of a cloud beside its points.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace curv {

class PointTable;

// Points stay where the file has them, whatever its VIEWPOINT says.
struct PcdFrame {
  // How the sensor was turned, a quaternion w x y z.
  std::array<double, 4> rotation = {1.0, 0.0, 0.0, 0.0};
  // The rows and columns of an organized cloud, row after row; 0 of others. A file has them if it has as many points.
  uint64_t width = 0;
  uint64_t height = 0;
};

// Says what of the table's viewpoint and frame a file of that extension, with its dot, has no place for; "" if nothing.
std::string NoteOnFrame(const PointTable& table, std::string_view extension);

}  // namespace curv
