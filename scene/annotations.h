#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/math/types.h"
#include "core/sculpt/carve_list.h"

namespace hapton {

// What a person has drawn and measured on the objects of a scene. Frame O of an object: its points as the scene file places them in frame
// S. An object that was picked up and put down elsewhere has another pose X_SO, and what was drawn on it moves along. Units: metres.

// A point on an object's surface.
struct AnnotationPoint {
  std::int32_t object = -1;
  Vec3 p_O = Vec3::Zero();
};

// A line drawn on an object; one point alone is a dot.
struct Stroke {
  std::int32_t object = -1;
  std::vector<Vec3> points_m;  // frame O
};

// The straight line between two touched points, of one object or of two.
struct Measure {
  std::array<AnnotationPoint, 2> ends;
};

using Annotation = std::variant<Stroke, Measure>;

// Where an object was put down: its point that the scene file places at p is now at p_m + q p. Frame: S.
struct PutDown {
  std::int32_t object = -1;
  Vec3 p_m = Vec3::Zero();
  Quat q = Quat::Identity();

  Pose pose() const;  // X_SO
};

// What one press of the button removed from an object that can be carved, rounded() (core/sculpt/carve.h). Frame: S, as the scene file
// places the object.
struct CarvedPress {
  std::int32_t object = -1;
  double radius_m = 0.0;  // of all carves
  std::vector<Carve> carves = {};

  friend bool operator==(const CarvedPress&, const CarvedPress&) = default;
};

// Objects are numbered as in `objects`: first those of the scene, in its order, then objects that a file named and the scene does not have.
// Entries on those others are kept for the file and not shown.
struct Annotations {
  std::vector<std::string> objects;
  std::vector<Annotation> entries;  // in the order in which they were made
  std::vector<PutDown> put_down;
  std::vector<CarvedPress> carved = {};         // in the order in which they were made; the shape depends neither on it nor on repetitions
  std::vector<std::size_t> carved_before = {};  // by entry: how many presses in `carved` were made before it; 0 for entries beyond its end
};

// Largest number of points in all strokes and measures; a file with more is rejected, and nothing more is drawn.
constexpr std::size_t kMaxAnnotationPoints = 100'000;

// Largest number of carves in a file: as many as a haptics node keeps.
constexpr std::size_t kMaxSavedCarves = CarveList::kMax;

std::size_t count_points(const Annotations& annotations);
// The number of carves in all presses.
std::size_t count_carves(const std::vector<CarvedPress>& carved);
// The carves of a list that are not undone, by press. first_serials: if given, gets the serial number of the first carve of each press.
std::vector<CarvedPress> group_carves(const CarveList& list, std::vector<std::uint32_t>* first_serials = nullptr);
// The length along the polyline.
double compute_length_m(const Stroke& stroke);

// The poses of the objects: X_SO by object. Objects beyond the list are where the scene file has them.
using ObjectPoses = std::vector<Pose>;

// The straight distance between the ends, with the objects at these poses, exact to rounding. On one object its pose has no effect.
double compute_length_m(const Measure& measure, const ObjectPoses& X_SO);
Vec3 place(const AnnotationPoint& point, const ObjectPoses& X_SO);

}  // namespace hapton
