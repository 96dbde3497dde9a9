#include "bench/haptons/extended_pair.h"
#include "bench/haptons/hapton_run.h"

#ifdef HAPTON_HAS_FCL
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

#include <algorithm>

namespace hapton {
namespace {

// FCL returns the points at which one triangle is deepest in the other, not the segment that both share. This judges FCL leniently: the
// returned point that is nearest to that segment counts.
double lenient_error(std::span<const Vec3> points, const TrianglePair& pair) {
  const ExtendedContact exact = intersect_extended(pair);
  const Vec3 from = exact.point[0].cast<double>();
  const Vec3 segment = exact.point[1].cast<double>() - from;
  double least = 1e300;
  for (const Vec3& p : points) {
    const double t = std::clamp((p - from).dot(segment) / std::max(segment.squaredNorm(), 1e-300), 0.0, 1.0);
    least = std::min(least, (p - from - t * segment).norm());
  }
  return points.empty() ? -1.0 : least / size_of(pair);
}

class FclTriangles final : public PairCollider {
 public:
  explicit FclTriangles(const std::vector<TrianglePair>& pairs) : pairs_(pairs), found_(pairs.size()) {}
  std::string name() const override { return "fcl_triangles"; }
  std::string what() const override {
    return "FCL's Intersect<double>::intersect_Triangle; its points are the deepest corners, not where edges meet";
  }
  bool is_peer() const override { return true; }
  void collide(std::size_t first, std::size_t count) override {
    for (std::size_t i = first; i < first + count; ++i) {
      const TrianglePair& p = pairs_[i];
      Found& f = found_[i];
      double depth = 0.0;
      Vec3 normal;
      f.count = 0;
      if (!fcl::detail::Intersect<double>::intersect_Triangle(p.a[0], p.a[1], p.a[2], p.b[0], p.b[1], p.b[2], f.point, &f.count, &depth,
                                                              &normal))
        f.count = 0;
    }
  }
  double location_error(std::size_t i) const override { return lenient_error({found_[i].point, found_[i].count}, pairs_[i]); }

 private:
  struct Found {
    Vec3 point[6];
    unsigned count = 0;
  };
  const std::vector<TrianglePair>& pairs_;
  std::vector<Found> found_;
};

class FclMeshes final : public PairCollider {
 public:
  explicit FclMeshes(const std::vector<TrianglePair>& pairs) : pairs_(pairs), found_(pairs.size()) {
    for (const TrianglePair& pair : pairs) {
      a_.push_back(make_model(pair.a));
      b_.push_back(make_model(pair.b));
    }
  }
  std::string name() const override { return "fcl_collide"; }
  std::string what() const override { return "fcl::collide on two meshes of one triangle, contacts on, building not timed; same points"; }
  bool is_peer() const override { return true; }
  void collide(std::size_t first, std::size_t count) override {
    const fcl::Transform3d still = fcl::Transform3d::Identity();
    const fcl::CollisionRequestd request(4, true);
    for (std::size_t i = first; i < first + count; ++i) {
      fcl::CollisionResultd result;
      fcl::collide(a_[i].get(), still, b_[i].get(), still, request, result);
      found_[i].count = std::min<unsigned>(4, static_cast<unsigned>(result.numContacts()));
      for (unsigned c = 0; c < found_[i].count; ++c) found_[i].point[c] = result.getContact(c).pos;
    }
  }
  double location_error(std::size_t i) const override { return lenient_error({found_[i].point, found_[i].count}, pairs_[i]); }

 private:
  using Model = fcl::BVHModel<fcl::OBBRSSd>;
  struct Found {
    Vec3 point[4];
    unsigned count = 0;
  };
  static std::unique_ptr<Model> make_model(const std::array<Vec3, 3>& t) {
    auto model = std::make_unique<Model>();
    model->beginModel(1, 3);
    model->addTriangle(t[0], t[1], t[2]);
    model->endModel();
    return model;
  }
  const std::vector<TrianglePair>& pairs_;
  std::vector<std::unique_ptr<Model>> a_, b_;
  std::vector<Found> found_;
};

}  // namespace

std::vector<std::unique_ptr<PairCollider>> make_fcl_colliders(const std::vector<TrianglePair>& pairs) {
  std::vector<std::unique_ptr<PairCollider>> colliders;
  colliders.push_back(std::make_unique<FclTriangles>(pairs));
  colliders.push_back(std::make_unique<FclMeshes>(pairs));
  return colliders;
}

}  // namespace hapton
#else
namespace hapton {
std::vector<std::unique_ptr<PairCollider>> make_fcl_colliders(const std::vector<TrianglePair>&) { return {}; }
}  // namespace hapton
#endif
