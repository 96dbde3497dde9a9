#include "scene/surface_points.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// Candidates for each point that is kept. More candidates spread the points more evenly, but take more time.
constexpr std::size_t kCandidatesPerPoint = 32;
// A triangle is seen edge-on from the front if its normal makes an angle with the view direction whose cosine is below this: a hand that
// comes from the front slides off it.
constexpr double kEdgeOnCosine = 0.05;

Vec3 area_vector(const TriangleMesh& mesh, std::size_t t) {
  return 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
}

// Centres of triangles at equal steps of accumulated projected area, as seen from the front (along z), where the hand comes from. For a
// scene that is seen edge-on as a whole: at equal steps of accumulated area.
std::vector<Vec3> draw_candidates(const TouchScene& scene, std::size_t count) {
  double projected_area = 0.0;
  double area = 0.0;
  for (const TouchObject& object : scene.objects) {
    for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
      const Vec3 vector = area_vector(*object.mesh, t);
      projected_area += std::abs(vector.z());
      area += vector.norm();
    }
  }
  const bool is_edge_on = projected_area < kEdgeOnCosine * area;
  const double total_weight = is_edge_on ? area : projected_area;
  const auto weight_of = [&](const TriangleMesh& mesh, std::size_t t) {
    const Vec3 vector = area_vector(mesh, t);
    return is_edge_on ? vector.norm() : std::abs(vector.z());
  };
  std::vector<Vec3> candidates;
  const double step = total_weight / static_cast<double>(count);
  double next = 0.5 * step;
  double passed = 0.0;
  for (const TouchObject& object : scene.objects) {
    for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t) {
      const double weight = weight_of(*object.mesh, t);
      passed += weight;
      if (!(passed >= next) || !(weight > kEdgeOnCosine * area_vector(*object.mesh, t).norm()) || candidates.size() == count) continue;
      candidates.push_back((object.mesh->corner(t, 0) + object.mesh->corner(t, 1) + object.mesh->corner(t, 2)) / 3.0);
      next = passed + step;
    }
  }
  return candidates;
}

}  // namespace

// Farthest-point sampling: the first point is the candidate nearest to the mean, each further one the farthest from all chosen ones.
std::vector<Vec3> find_surface_points(const TouchScene& scene, std::size_t max_points) {
  std::vector<Vec3> candidates = draw_candidates(scene, kCandidatesPerPoint * max_points);
  if (candidates.empty()) return {};
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : candidates) middle += p / static_cast<double>(candidates.size());
  std::vector<double> priorities(candidates.size());
  std::transform(candidates.begin(), candidates.end(), priorities.begin(), [&](const Vec3& p) { return -(p - middle).squaredNorm(); });
  std::vector<Vec3> points;
  while (points.size() < std::min(max_points, candidates.size())) {
    const auto chosen = static_cast<std::size_t>(std::max_element(priorities.begin(), priorities.end()) - priorities.begin());
    points.push_back(candidates[chosen]);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double distance = (candidates[i] - points.back()).squaredNorm();
      priorities[i] = points.size() == 1 ? distance : std::min(priorities[i], distance);
    }
  }
  return points;
}

}  // namespace hapton
