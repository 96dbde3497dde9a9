#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/collision/uniform_grid.h"
#include "core/force/smooth/smooth_scene.h"
#include "core/force/touch_scene.h"
#include "vision_node/teach_choice.h"

namespace hapton {

using TeachColour = std::array<std::uint8_t, 3>;

struct TeachLine {
  Vec3 from;
  Vec3 to;
  TeachColour colour;
};
struct TeachTriangle {
  std::array<Vec3, 3> corner;
  std::array<TeachColour, 3> colour;
};
// A scale of colours at the left edge of the picture: from low through zero to high.
struct TeachLegend {
  double limit = 0.0;  // the scale goes from -limit to limit
  std::string unit;
};

// What a teaching view draws. Frame S, metres.
struct TeachShapes {
  TeachChoice choice;  // the view that the shapes were made for
  std::vector<TeachLine> lines;
  std::vector<TeachTriangle> triangles;
  std::optional<TeachLegend> legend;
  std::string caption;  // a line for the picture's corner
};

// The probe as it is shown. Frame S.
struct TeachProbe {
  Vec3 p_SP = Vec3::Zero();
  Vec3 p_SD = Vec3::Zero();
  Vec3 force_S_n = Vec3::Zero();
  bool is_contact = false;
  double radius_m = 0.0;
  int set_size = 64;  // number of triangles of the local set
};

// However many triangles a scene has, make_tree_shapes() and make_curvature_shapes() draw at most so many hulls and triangles, the nearest
// to the probe.
constexpr std::size_t kMaxTeachHulls = 1'000;
constexpr std::size_t kMaxTeachTriangles = 60'000;
// The number of cells of the grid along each axis, as in the memo.
constexpr int kTeachCells = 32;

// The triangles in contact with the probe (within a tolerance), a plane and normal for each flat face of them, and the penetration vector.
TeachShapes make_contact_shapes(const SmoothScene& scene, const TeachProbe& probe);
// The local set that the slow task of `smooth` would send for a probe at rest at p_SP, selected by the same function.
TeachShapes make_local_set_shapes(const SmoothScene& scene, const TeachProbe& probe);
// The Fixed Direction Hulls at one level of the tree of `smooth`; level 0: the children of the root.
TeachShapes make_tree_shapes(const SmoothScene& scene, const TeachProbe& probe, int level);

// The memo's grid over all triangles of a scene. Error: see UniformGrid::make.
Result<UniformGrid> make_teach_grid(const TouchScene& scene);
// The edges of the grid's occupied cells, each once, and the cell of the probe.
TeachShapes make_grid_shapes(const UniformGrid& grid, const TeachProbe& probe);

// Mean curvature of all vertices, with the scale for their colours: 95 % of the known values are from -limit to limit.
struct TeachCurvature {
  std::vector<std::vector<double>> by_object;  // curvature of each vertex of each object, 1/m; not finite: not known
  double limit = 0.0;
};
TeachCurvature find_curvature(const TouchScene& scene);
TeachShapes make_curvature_shapes(const TouchScene& scene, const TeachCurvature& curvature, const TeachProbe& probe);
// The colour of a curvature: from blue (hollow) through light grey to red (convex); yellow: not known.
TeachColour curvature_colour(double curvature, double limit);

}  // namespace hapton
