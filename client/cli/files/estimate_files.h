// Estimates the curvature of files: one, or many into a directory.
#pragma once

#include <string>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/connection_flags.h"
#include "client/cli/normals/normal_flags.h"
#include "client/cli/quantities/quantity_flags.h"
#include "client/cli/scale/scale_flags.h"
#include "client/curvature_client.h"
#include "client/io/table_file.h"

namespace curv {

struct EstimateFlags {
  std::vector<std::string> inputs;
  std::string output;
  std::string input_format;  // of inputs whose name does not tell it
  SaveOptions save;
  bool force = false;
  bool tiles = false;           // whether the file is estimated in tiles
  std::string tiles_directory;  // where these are kept until all is done; empty: beside the output
  std::string given;            // the options on the command line that results depend on
  ConnectionFlags connection;
  int threads = 0;
  ScaleFlags scale;
  double timeout = 0.0;  // seconds; 0: none
  double connect_timeout = 1.5;
  std::string summary = "text";
  std::string color;
  NormalFlags normals;
  QuantityFlags quantities;
  EstimateOptions options;
};

// Runs `curv estimate`. Prints summaries and errors, and returns how it ended.
ExitCode EstimateFiles(const EstimateFlags& flags);

}  // namespace curv
