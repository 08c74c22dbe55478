// Clouds for tests: positions and normals, three floats a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace curvd {

struct TestCloud {
  std::vector<float> positions;
  std::vector<float> normals;     // none, or one for each point
  std::vector<float> viewpoints;  // likewise

  size_t size() const { return positions.size() / 3; }
  void Add(float x, float y, float z, float nx, float ny, float nz);
  // Packed points [first, first + count); empty where there are none.
  std::string PackedPositions(size_t first, size_t count) const;
  std::string PackedNormals(size_t first, size_t count) const;
  std::string PackedViewpoints(size_t first, size_t count) const;
};

// Evenly spread over a sphere (golden-angle spiral), outward normals.
TestCloud Sphere(size_t count, float radius);

// A torus with radii 2 and 1 around the z axis, points from a fixed additive sequence, outward normals.
TestCloud Torus(size_t count);

// The square [0, 1]^2 in the plane z = 0, normals along z.
TestCloud Square(size_t count);

}  // namespace curvd
