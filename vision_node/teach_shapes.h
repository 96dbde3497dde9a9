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

// The shapes of one teaching view: a picture of the data that a method computes with (docs/vision.md, "Teaching views"). Frame S, metres.
struct TeachShapes {
  TeachChoice choice;  // the view that the shapes were made for; the functions below leave it as it is, TeachBuilder sets it
  std::vector<TeachLine> lines;
  std::vector<TeachTriangle> triangles;
  std::optional<TeachLegend> legend;
  std::string caption;  // a line for the picture's corner
};

// The probe as it is drawn, and the settings of its method that a view needs. Frame S.
struct TeachProbe {
  Vec3 p_SP = Vec3::Zero();       // proxy, m
  Vec3 p_SD = Vec3::Zero();       // device point, m
  Vec3 force_S_n = Vec3::Zero();  // force on the hand
  bool is_contact = false;
  double radius_m = 0.0;  // of a sphere probe; 0: a point
  int set_size = 64;      // number of triangles of the local set; the default of method `smooth` (MethodSettings::set_size)
};

// make_tree_shapes() draws at most kMaxTeachHulls hulls, make_curvature_shapes() at most kMaxTeachTriangles triangles: those nearest to the
// probe. The limits bound the size of a picture, which is made anew as the probe moves. Their values are free choices.
constexpr std::size_t kMaxTeachHulls = 1'000;  // of at most 36 edges each
constexpr std::size_t kMaxTeachTriangles = 60'000;
// The number of cells of the grid along each axis, as in the HP memo of 1996.
constexpr int kTeachCells = 32;

// The triangles in contact with the probe, a plane and normal for each flat face of them, and the penetration vector. In contact are the
// triangles up to 0.02 % of the scene's diagonal from the proxy, or from the surface of a sphere probe.
TeachShapes make_contact_shapes(const SmoothScene& scene, const TeachProbe& probe);
// The triangles that the fast task of method `smooth` would compute with if the proxy were at rest at p_SP (the local set). The function
// that selects them is that of the slow task.
TeachShapes make_local_set_shapes(const SmoothScene& scene, const TeachProbe& probe);
// The Fixed Direction Hulls at one level of the tree of method `smooth`; level 0: the children of the root.
TeachShapes make_tree_shapes(const SmoothScene& scene, const TeachProbe& probe, int level);

// The grid of the HP memo (method `sweep`) over all triangles of a scene. Error: see UniformGrid::make.
Result<UniformGrid> make_teach_grid(const TouchScene& scene);
// The edges of the grid's occupied cells, each edge once, and the edges of the cell that contains the proxy.
TeachShapes make_grid_shapes(const UniformGrid& grid, const TeachProbe& probe);

// Mean curvature of all vertices, and the scale for their colours.
struct TeachCurvature {
  std::vector<std::vector<double>> by_object;  // curvature of each vertex of each object, 1/m; not finite: not known
  double limit = 0.0;                          // 95 % of the known curvatures are from -limit to limit, 1/m
};
TeachCurvature find_curvature(const TouchScene& scene);
// The triangles of a scene in the colours of their curvature, with a legend.
TeachShapes make_curvature_shapes(const TouchScene& scene, const TeachCurvature& curvature, const TeachProbe& probe);
// The colour of a curvature: from blue (concave) through light grey (flat) to red (convex); yellow: not known.
TeachColour curvature_colour(double curvature, double limit);

}  // namespace hapton
