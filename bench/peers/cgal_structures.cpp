#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>
#include <optional>
#include <vector>

#include "bench/peers/peer_structures.h"

namespace hapton {
namespace {

// AABB_tree over a kernel of plain doubles. nearest() gives closest_point its last result as a hint, as for a moving probe; closest_point
// has no search radius. first_hit() takes the first of all intersections, because CGAL has no query for the first one only.
class Cgal final : public QueryStructure {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Point = Kernel::Point_3;
  using Segment = Kernel::Segment_3;
  using Faces = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Faces::const_iterator>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

 public:
  explicit Cgal(const TriangleMesh& mesh) {
    faces_.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      Kernel::Triangle_3 face(point(mesh.corner(i, 0)), point(mesh.corner(i, 1)), point(mesh.corner(i, 2)));
      if (!face.is_degenerate()) faces_.push_back(face);  // CGAL does not define the intersections of degenerate triangles
    }
    tree_.insert(faces_.begin(), faces_.end());
    tree_.build();
    if (!faces_.empty()) hint_ = faces_.front().vertex(0);
  }
  double first_hit(const Vec3& from, const Vec3& to) override {
    found_.clear();
    tree_.all_intersections(Segment(point(from), point(to)), std::back_inserter(found_));
    double t = kNothingFound;
    const Vec3 segment = to - from;
    const auto part = [&](const Point& p) { return (Vec3(p.x(), p.y(), p.z()) - from).dot(segment) / segment.squaredNorm(); };
    for (const auto& one : found_) {
      if (const auto* p = boost::get<Point>(&one.first)) t = std::min(t, part(*p));
      if (const auto* s = boost::get<Segment>(&one.first)) t = std::min({t, part(s->source()), part(s->target())});
    }
    return t;
  }
  double nearest(const Vec3& p, double radius) override {
    const Point q = point(p);
    hint_ = tree_.closest_point(q, hint_);
    const double distance = std::sqrt(CGAL::squared_distance(q, hint_));
    return distance <= radius ? distance : kNothingFound;
  }

 private:
  static Point point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

  Faces faces_;
  Tree tree_;
  Point hint_;
  std::vector<Tree::Intersection_and_primitive_id<Segment>::Type> found_;
};

}  // namespace

std::vector<QueryStructureKind> cgal_structures() {
  return {{.library = {},
           .name = "cgal aabb tree",
           .precision = "double",
           .note = "all_intersections of a segment; closest_point from the last result, without a radius",
           .make = [](const TriangleMesh& mesh) -> Result<std::unique_ptr<QueryStructure>> { return std::make_unique<Cgal>(mesh); }}};
}

}  // namespace hapton
