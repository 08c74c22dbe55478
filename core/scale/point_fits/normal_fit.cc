#include "core/scale/point_fits/normal_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/scale/point_fits/field_curvature.h"

namespace curvd {
namespace {

// This share of the neighbors, the nearest, tells what the fit of all of them smooths away.
constexpr double kCheckingShare = 0.7;

// Equations for the normals of neighbors up to a distance, each of which weighs 1 - r^2 / reach^2.
PolynomialEquations<3> EquationsWithin(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors,
                                       double reach) {
  PolynomialEquations<3> equations;
  for (const NeighborNormal* const neighbor : neighbors) {
    const double x = frame.u.dot(neighbor->offset) / reach, y = frame.v.dot(neighbor->offset) / reach;
    equations.Add(x, y, neighbor->normal, std::max(1.0 - x * x - y * y, 0.0));
  }
  return equations;
}

// What a fit of that degree says, if chance makes no larger error of it.
template <int kDegree>
std::optional<PointFit> CurvatureInDegree(const NormalFrame& frame, const PolynomialEquations<3>& equations,
                                          size_t count, double radius, double allowed_error) {
  const double freedom = static_cast<double>(count) - kPolynomialTerms[kDegree];
  if (!(freedom > 0.0)) return std::nullopt;
  const auto fit = equations.SolveDegree<kDegree>();
  if (!fit.has_value()) return std::nullopt;
  const double variance = 0.5 * fit->squares / equations.weights() * static_cast<double>(count) / freedom;
  const double error = 0.5 * std::sqrt(variance * (fit->Variance(1) + fit->Variance(2))) / radius;
  if (!(error <= allowed_error)) return std::nullopt;
  const auto point = CurvatureOfField(frame, fit->coefficients.template topRows<3>(), radius, radius);
  if (!point.has_value()) return std::nullopt;
  const double of_principal = std::sqrt(2.0) * error;
  return PointFit{*point, count, error, of_principal, of_principal, false};
}

}  // namespace

std::optional<PointFit> EstimateByNormals(const NormalFrame& frame, std::span<const NeighborNormal* const> neighbors,
                                          double radius, double allowed_error) {
  const std::optional<NormalFitWithBias> found = EstimateWithBias(frame, neighbors, radius, allowed_error);
  return found.has_value() ? std::optional(found->fit) : std::nullopt;
}

std::optional<NormalFitWithBias> EstimateWithBias(const NormalFrame& frame,
                                                  std::span<const NeighborNormal* const> neighbors, double radius,
                                                  double allowed_error) {
  constexpr double kAnyError = std::numeric_limits<double>::infinity();
  const PolynomialEquations<3> equations = EquationsWithin(frame, neighbors, radius);
  auto found = CurvatureInDegree<3>(frame, equations, neighbors.size(), radius, allowed_error);
  if (!found.has_value()) found = CurvatureInDegree<2>(frame, equations, neighbors.size(), radius, allowed_error);
  if (!found.has_value()) found = CurvatureInDegree<1>(frame, equations, neighbors.size(), radius, kAnyError);
  if (!found.has_value()) return std::nullopt;
  NormalFitWithBias with_bias{*found, 0.0};
  const auto nearest = neighbors.first(static_cast<size_t>(kCheckingShare * static_cast<double>(neighbors.size())));
  const double reach = nearest.empty() ? 0.0 : nearest.back()->offset.norm();
  if (!(reach > 0.0)) return with_bias;
  const PolynomialEquations<3> of_nearest = EquationsWithin(frame, nearest, reach);
  const auto check = CurvatureInDegree<3>(frame, of_nearest, nearest.size(), reach, kAnyError);
  if (!check.has_value()) return with_bias;
  const auto change = [&](float PointCurvature::*curvature) {
    return std::abs(double{found->point.*curvature} - check->point.*curvature);
  };
  const double noise = std::hypot(found->mean_error, check->mean_error);
  if (noise > 0.0) with_bias.bias_over_noise = change(&PointCurvature::mean) / noise;
  PointFit& fit = with_bias.fit;
  fit.mean_error = std::hypot(fit.mean_error, change(&PointCurvature::mean));
  fit.k1_error = std::hypot(fit.k1_error, change(&PointCurvature::k1));
  fit.k2_error = std::hypot(fit.k2_error, change(&PointCurvature::k2));
  return with_bias;
}

}  // namespace curvd
