// Makes calls over the connections of one C++ client: replica_calls SERVER CALLS. Exits with 5 if one fails.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "client/curvature_client.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("usage: replica_calls SERVER CALLS\n", stderr), 2;
  const auto client = curv::CurvatureClient::Connect(argv[1]);
  if (!client.ok()) return std::fprintf(stderr, "%s\n", client.status().ToString().c_str()), 2;
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  curv::EstimateOptions options;
  options.neighbor_count = 4;
  for (int call = 0; call < std::atoi(argv[2]); ++call) {
    const auto result = (*client)->Estimate(curv::CloudView(positions, normals), options);
    if (!result.ok()) return std::fprintf(stderr, "%s\n", result.status().ToString().c_str()), 5;
  }
  return 0;
}
