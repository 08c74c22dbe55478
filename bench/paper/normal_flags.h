// The flags that say where the normals of samples come from.
#pragma once

#include <cstdint>
#include <string>

#include "CLI/CLI.hpp"
#include "bench/paper/samples.h"

namespace curvd::bench {

struct NormalFlags {
  bool makes = false;      // curvd makes them
  uint32_t fitted_of = 0;  // neighbors of which they are made before they are given; 0: they are the samples' own
  std::string fitted_by = "pca";  // and by which fit
};

inline void AddNormalFlags(CLI::App& app, NormalFlags& flags) {
  app.add_flag("--make-normals", flags.makes, "Normals are made of the positions, in place of the samples' own");
  app.add_option("--fitted-normals", flags.fitted_of,
                 "Normals are given, but made of so many neighbors each, as by other programs; 0: the samples' own");
  app.add_option("--normal-fit", flags.fitted_by, "By which fit: pca, jet-2 or jet-4")
      ->check(CLI::IsMember({"pca", "jet-2", "jet-4"}));
}

// The samples with the normals that are given to an estimate.
inline Samples WithNormals(Samples samples, const NormalFlags& flags, WorkerPool& pool) {
  if (flags.fitted_of == 0) return samples;
  return WithFittedNormals(samples, flags.fitted_by, flags.fitted_of, pool);
}

}  // namespace curvd::bench
