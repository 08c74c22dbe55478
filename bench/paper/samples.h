// Samples of analytic surfaces with the exact curvature at each: even, thinned out, scanned, and the paper's own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/surfaces/surface.h"
#include "core/cloud/cloud.h"
#include "core/job/estimation_job.h"

namespace curvd::bench {

struct Samples {
  std::string surface;
  std::string sampling;  // one of kSampleSpreads, or the paper's: "paper", "filter", "lidar"
  std::vector<curv::Vec3> positions;
  std::vector<curv::Vec3> normals;           // unit, outward
  std::vector<curv::SurfaceGeometry> truth;  // at the undisturbed positions

  size_t size() const { return positions.size(); }
};

// The names of the ways below in which points are spread, in their order.
inline constexpr const char* kSampleSpreads[] = {"even", "thinned", "falling", "random", "scanned"};

// Surfaces are named as curv generate has them, or as held_out_surfaces.h. All of these end the program on failure, and
// are functions of their arguments alone.

// `points` points, evenly spread, as `curv generate` makes them.
Samples SampleEvenly(const std::string& surface, size_t points, uint64_t seed);

// Even samples of which each stays with a probability from 0.1 (along x = -y) to 1 (along x = y): about half of them.
// The density varies as in the paper's "filter" clouds.
Samples SampleThinned(const std::string& surface, size_t points, uint64_t seed);

// Even samples of which each stays with a probability that falls from 1, at the least x, to 0.01 at the greatest: about
// `points` of them. An end is as thinly sampled as where a scanner sees it from afar.
Samples SampleFalling(const std::string& surface, size_t points, uint64_t seed);

// About `points` points that lie by chance: each of eight times as many even samples stays with a probability of 1/8.
Samples SampleAtRandom(const std::string& surface, size_t points, uint64_t seed);

// What a scanner on the z axis sees: first hits of rays on a grid of angles, 2.5 times denser along a scan line than
// across, with grazing rays left out. Open where the surface is hidden. As the paper's "lidar" clouds.
Samples SampleScanned(const std::string& surface);

// About `points` samples, spread in the way of that name; a scan has as many as its rays meet.
Samples SampleAs(const std::string& sampling, const std::string& surface, size_t points, uint64_t seed);

// The points of a file, with the truth at the nearest position of the surface; nothing if the file does not exist.
std::optional<Samples> LoadSamples(const std::string& path, const std::string& surface, const std::string& sampling);

// The length of the paper's unit of noise, which is for surfaces about 20 wide.
double NoiseUnit(const std::string& surface);

// The same samples under Gaussian noise on positions and normals (client/surfaces/noise.h). The truth stays.
Samples Perturbed(const Samples& samples, double position_noise, double normal_noise, uint64_t seed);

// The same samples with normals that are made of their positions, each of `neighbor_count` neighbors, on the side of
// the samples' own: as other programs make them, whose errors neighbors share. Where no fit is made, the own one stays.
// With several scans, points belong to these in turn, and only those of the same scan are neighbors.
Samples WithFittedNormals(const Samples& samples, NormalMethod method, uint32_t neighbor_count, size_t scans,
                          WorkerPool& pool);

// The same samples, whose normals are the means of those of so many nearest samples, their own included.
Samples WithSmoothedNormals(const Samples& samples, size_t count);

// As the core takes them: float32.
Cloud ToCloud(const Samples& samples);

// Estimates by the samples' normals, or, if these are to be made, by those that the core makes of their positions, on
// the side of the samples' own. Nobody looks for outliers where the samples are a part of a larger cloud.
EstimationResult EstimateSamples(const Samples& samples, const EstimatorOptions& options, bool makes_normals,
                                 WorkerPool& pool, bool is_part = false);

}  // namespace curvd::bench
