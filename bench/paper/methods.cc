#include "bench/paper/methods.h"

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace curvd::bench {
namespace {

Method Plain(const std::string& name, std::string_view kind) {
  Method method{.name = name, .options = {}};
  method.options.estimator = kind;
  return method;
}

Method AvgHexagram(uint32_t rotations) {
  Method method = Plain(absl::StrCat("avg-hexagram R=", rotations), "avg-hexagram");
  method.options.rotation_count = rotations;
  return method;
}

Method Triangles(const std::string& name, std::string_view kind, uint32_t triangles) {
  Method method = Plain(absl::StrCat(name, " L=", triangles), kind);
  method.options.triangle_count = triangles;
  return method;
}

// The paper's, all triangles alike.
Method EvenDelaunay() {
  Method method = Plain("delaunay even", "delaunay");
  method.options.even_weights = true;
  return method;
}

Method Jet(uint32_t degree) {
  Method method = Plain(absl::StrCat("jet degree ", degree), "jet");
  method.options.jet_degree = degree;
  return method;
}

}  // namespace

std::vector<Method> PaperMethods() {
  std::vector<Method> methods;
  for (uint32_t rotations = 1; rotations <= kMaxRotations; ++rotations) methods.push_back(AvgHexagram(rotations));
  methods.push_back(Plain("hexagram", "hexagram"));
  for (uint32_t triangles : {10u, 50u, 100u, 200u}) {
    methods.push_back(Triangles("uniform", "uniform", triangles));
  }
  methods.push_back(Triangles("independent", "independent", 100));
  methods.push_back(Plain("delaunay", "delaunay"));
  methods.push_back(EvenDelaunay());
  methods.push_back(Jet(2));
  methods.push_back(Jet(4));
  methods.push_back(Plain("aso", "aso"));
  return methods;
}

Method MethodNamed(const std::string& name) {
  const std::vector<Method> methods = PaperMethods();
  return *std::find_if(methods.begin(), methods.end(), [&](const Method& method) { return method.name == name; });
}

}  // namespace curvd::bench
