#include "bench/peers/plain_estimator.h"

#include <cmath>

namespace curvd::bench {
namespace {

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;
};

Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
double Dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector Cross(Vector a, Vector b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Vector Normalized(Vector a) { return (1.0 / std::sqrt(Dot(a, a))) * a; }

template <typename Scalar>
Vector At(const Scalar* triples, uint32_t i) {
  return {triples[3 * size_t{i}], triples[3 * size_t{i} + 1], triples[3 * size_t{i} + 2]};
}

struct Frame {
  Vector u, v;
};

// u = n x e with e the axis after the largest component of n, v = n x u.
Frame TangentFrame(Vector n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const Vector e = z > x && z > y ? Vector{1, 0, 0} : y > x ? Vector{0, 0, 1} : Vector{0, 1, 0};
  const Vector u = Normalized(Cross(n, e));
  return {u, Cross(n, u)};
}

constexpr double kHalfSqrt3 = 0.86602540378443864676;

// curvd does not bring averages of normals shorter than this back to unit length
// (core/estimators/hexagram/hexagram-inl.h).
constexpr double kShortNormal = 0.1;

struct Targets {
  Vector position[6];  // relative to the query
};

Targets HexagramTargets(const Frame& frame, double rho) {
  const Vector u = rho * frame.u, v = rho * frame.v;
  const Vector a = u, b = 0.5 * u + kHalfSqrt3 * v, c = -0.5 * u + kHalfSqrt3 * v;
  return {{a, b, c, -1.0 * a, -1.0 * b, -1.0 * c}};
}

int NearestTarget(const Targets& targets, Vector offset) {
  int nearest = 0;
  double least = INFINITY;
  for (int s = 0; s < 6; ++s) {
    const Vector d = offset - targets.position[s];
    const double squared = Dot(d, d);
    if (squared < least) {
      least = squared;
      nearest = s;
    }
  }
  return nearest;
}

int SectorOf(const Frame& frame, Vector offset) {
  const double x = Dot(offset, frame.u), y = 2.0 * kHalfSqrt3 * Dot(offset, frame.v);
  // The signs of x, y - x and y + x tell the six sectors apart.
  constexpr int8_t kSector[8] = {4, -1, 3, 2, 5, 0, -1, 1};
  return kSector[(x > 0) * 4 + (y > x) * 2 + (y > -x)];
}

struct Corner {
  Vector position, normal;
};

struct Measures {
  double area = 0, mean = 0, gaussian = 0, uu = 0, uv = 0, vv = 0;
};

// Property 1 of the paper, with 1/4 in the mean measure.
void AddTriangle(const Corner& a, const Corner& b, const Corner& c, const Frame& frame, Measures& sum) {
  const Vector w = (1.0 / 3.0) * (a.normal + b.normal + c.normal);
  const Vector e1 = b.position - a.position, e2 = c.position - a.position;
  const Vector n1 = b.normal - a.normal, n2 = c.normal - a.normal;
  const double area = 0.5 * Dot(w, Cross(e1, e2));
  const double turn = area < 0.0 ? -1.0 : 1.0;
  sum.area += turn * area;
  sum.mean += turn * 0.25 *
              Dot(w, Cross(c.normal - b.normal, a.position) + Cross(a.normal - c.normal, b.position) +
                         Cross(b.normal - a.normal, c.position));
  sum.gaussian += turn * 0.5 * Dot(a.normal, Cross(b.normal, c.normal));
  const auto tensor = [&](Vector x, Vector y) {
    return turn * 0.5 * Dot(w, Dot(y, n1) * Cross(x, e2) - Dot(y, n2) * Cross(x, e1));
  };
  sum.uu += tensor(frame.u, frame.u);
  sum.uv += 0.5 * (tensor(frame.u, frame.v) + tensor(frame.v, frame.u));
  sum.vv += tensor(frame.v, frame.v);
}

void Store(Vector v, std::array<float, 3>& out) {
  out = {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

PointCurvature CurvatureOf(const Measures& m, const Frame& frame, double radius) {
  const double mean = m.mean / m.area;
  const double a = 0.5 * (m.uu - m.vv) / m.area, b = m.uv / m.area, r = std::sqrt(a * a + b * b);
  const Vector second = a >= 0.0 ? (a + r) * frame.u + b * frame.v : b * frame.u + (r - a) * frame.v;
  const Vector d2 = r > 0.0 ? Normalized(second) : frame.u;
  PointCurvature out;
  out.mean = static_cast<float>(mean);
  out.gaussian = static_cast<float>(m.gaussian / m.area);
  out.k1 = static_cast<float>(mean - r);
  out.k2 = static_cast<float>(mean + r);
  Store(Cross(d2, Cross(frame.u, frame.v)), out.d1);
  Store(d2, out.d2);
  out.radius = static_cast<float>(radius);
  out.status = PointStatus::kOk;
  return out;
}

}  // namespace

template <typename Scalar>
PointCurvature PlainAvgHexagram(const Scalar* positions, const Scalar* normals, uint32_t query,
                                const uint32_t* neighbors, size_t count, double radius, PeerWork work) {
  Vector mean_normal;
  for (size_t j = 0; j < count; ++j) mean_normal = mean_normal + At(normals, neighbors[j]);
  const Vector own = At(normals, query);
  const Vector n = Normalized(0.5 * own + (0.5 / static_cast<double>(count)) * mean_normal);
  const Frame frame = TangentFrame(n);
  const Targets targets = HexagramTargets(frame, 0.5 * radius);
  const Vector origin = At(positions, query);
  Corner corners[6];
  int counts[6] = {};
  for (size_t j = 0; j < count; ++j) {
    if (neighbors[j] == query) continue;
    const Vector offset = At(positions, neighbors[j]) - origin;
    const int s = work == PeerWork::kTunedEstimate ? SectorOf(frame, offset) : NearestTarget(targets, offset);
    corners[s].position = corners[s].position + offset;
    corners[s].normal = corners[s].normal + At(normals, neighbors[j]);
    ++counts[s];
  }
  bool opposed = false;
  for (int s = 0; s < 6; ++s) {
    const double per_count = 1.0 / (counts[s] > 0 ? counts[s] : 1);
    const double length = per_count * std::sqrt(Dot(corners[s].normal, corners[s].normal));
    opposed |= counts[s] > 0 && length < kShortNormal;
    corners[s].position = per_count * corners[s].position;
    corners[s].normal = counts[s] > 0 ? (per_count / length) * corners[s].normal : own;
  }
  Measures measures;
  AddTriangle(corners[0], corners[2], corners[4], frame, measures);
  AddTriangle(corners[1], corners[3], corners[5], frame, measures);
  PointCurvature out = CurvatureOf(measures, frame, radius);
  if (opposed) out.status = PointStatus::kInconsistentNormals;
  return out;
}

template PointCurvature PlainAvgHexagram(const float*, const float*, uint32_t, const uint32_t*, size_t, double,
                                         PeerWork);
template PointCurvature PlainAvgHexagram(const double*, const double*, uint32_t, const uint32_t*, size_t, double,
                                         PeerWork);

}  // namespace curvd::bench
