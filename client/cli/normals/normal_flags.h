// The flags that say where normals come from, and which side of the surface is out.
#pragma once

#include <cstdint>
#include <string>

#include "client/io/oriented_cloud.h"
#include "client/io/point_table.h"
#include "client/normal_options.h"

namespace CLI {
class App;
}  // namespace CLI

namespace curv {

struct NormalFlags {
  NormalSource source = NormalSource::kGiven;
  // How normals are made.
  std::string method;
  std::string k = "auto";
  double radius = 0.0;  // 0: none
  // Which side is out: one of these at most.
  bool consistent = false;
  bool closed = false;
  std::string viewpoint;
  std::string up;

  bool ChoosesSide() const { return consistent || closed || !viewpoint.empty() || !up.empty(); }
  bool ChoosesMethod() const { return !method.empty() || k != "auto" || radius > 0.0; }
};

// Each adds flags to a command. `flags` must outlive `command`.
// --normals and --orient.
void AddSourceFlags(CLI::App& command, NormalFlags& flags);
// --consistent, --closed, --viewpoint=X,Y,Z and --up[=AXIS or X,Y,Z], which exclude each other.
void AddSideFlags(CLI::App& command, NormalFlags& flags);
// How normals are made: --PREFIXmethod, --PREFIXk and --PREFIXradius.
void AddMethodFlags(CLI::App& command, const std::string& prefix, NormalFlags& flags);

// Throws CLI::ValidationError if flags say something about normals that are to be taken as given.
void CheckSource(const NormalFlags& flags);

// The options for the normals of a table. If no flag chooses a side, the table does: a viewpoint for each point
// (FindViewpoints), else one for all, else neither. `note` is set to what the table chose, for the user; it is empty if
// it chose nothing.
NormalOptions OptionsFor(const NormalFlags& flags, const PointTable& table, std::string& note);

// What calls with those options send of a table.
CloudNeeds NeedsOf(const NormalOptions& options);

}  // namespace curv
