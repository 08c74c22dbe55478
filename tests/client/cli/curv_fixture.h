// What tests of the program have in common.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/io/point_table.h"
#include "tests/client/cli/run_curv.h"
#include "tests/client/temp_dir.h"

namespace curv {

inline std::vector<std::string> ColumnNames(const PointTable& table) {
  std::vector<std::string> names;
  for (const Column& column : table.columns()) names.push_back(column.name);
  return names;
}

class CurvTest : public ::testing::Test {
 protected:
  // A small cloud with normals and truth.
  std::string Cloud(const std::string& surface = "torus", const std::string& points = "2000") {
    const std::string path = dir_.File(surface + ".ply");
    const CurvRun run = RunCurv({"generate", surface, "--points=" + points, "-o", path});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return path;
  }

  const TempDir dir_;
};

}  // namespace curv
