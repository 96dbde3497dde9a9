#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {
namespace {

// A step of a slide in which a concave edge releases the point in mid-step and would hold it again at the end: if the device jumps to the
// end at once, the point stays.
struct ReleaseInMidStep {
  unsigned seed;
  std::size_t step;
};

class ProxyFollow : public testing::TestWithParam<ReleaseInMidStep> {
 protected:
  static constexpr std::size_t kRows = 10000;

  static std::unique_ptr<ForceMethod> make(const char* name, const TriangleMesh& mesh) {
    MethodSettings settings;
    settings.name = name;
    TouchScene scene;
    TouchObject object;
    object.mesh = std::make_shared<const TriangleMesh>(mesh);
    scene.objects.push_back(object);
    return make_method(settings, scene).value();
  }

  // The output at `step` of a run from the beginning of that segment of the slide.
  static MethodOutput felt_at(ForceMethod& method, const TouchTrajectory& slide, std::size_t step) {
    const std::size_t first = step / slide.reset_every * slide.reset_every;
    method.reset(slide.p_SD[first]);
    MethodOutput felt;
    for (std::size_t i = first; i <= step; ++i) felt = method.step({.p_SD = slide.p_SD[i], .dt_s = 1e-3});
    return felt;
  }
};

TEST_P(ProxyFollow, EndsWhereAContinuousMotionDoes) {
  const TriangleMesh mesh = make_bumpy_sphere(0.045, 0.25, 20000, 1);
  const auto slide = make_slide_trajectory(mesh, {.seed = GetParam().seed, .rows = kRows, .rate_hz = 1000.0}).value();
  const auto proxy = make("proxy", mesh);
  const auto reference = make("reference", mesh);
  for (std::size_t step = GetParam().step - 1; step <= GetParam().step + 2; ++step) {
    const Vec3 force = felt_at(*reference, slide, step).force_n;
    EXPECT_LE((felt_at(*proxy, slide, step).force_n - force).norm(), 1e-4 * force.norm()) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Slides, ProxyFollow, testing::Values(ReleaseInMidStep{10, 9121}, ReleaseInMidStep{18, 1387}),
                         [](const auto& test) { return "seed_" + std::to_string(test.param.seed); });

// A floor in z = 0, y < 0, whose faces are walkable, and a wall in y = 0, whose faces are not, because a band crosses all of them. Behind
// the wall are copies of it. Near the vertices in which the faces of the wall and of its copies meet, there are hundreds of triangles.
class CrowdedWall {
 public:
  static constexpr std::uint32_t kFaces = 40;
  static constexpr std::uint32_t kCopies = 12;

  CrowdedWall() {
    constexpr double kRadius = 0.3;
    constexpr double kHalfTurn = std::numbers::pi;
    constexpr std::uint32_t kSlices = 6;
    const std::uint32_t middle = add({0.0, 0.0, 0.0});
    const std::uint32_t right = add_arc(kRadius, 0.0);
    add_faces(middle, right);
    std::uint32_t inner = right + kFaces;
    std::uint32_t outer = add({-1.0, 0.0, 0.0});
    for (std::uint32_t i = 1; i <= kSlices; ++i) {
      const double angle = kHalfTurn + kHalfTurn * i / kSlices;
      const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
      const std::uint32_t next = i == kSlices ? right : add(kRadius * out);
      const std::uint32_t next_outer = add(out);
      mesh.triangles.insert(mesh.triangles.end(), {{middle, inner, next}, {inner, outer, next_outer}, {inner, next_outer, next}});
      inner = next;
      outer = next_outer;
    }
    const std::uint32_t band = add_arc(0.2, -0.01, 0.02);
    add_arc(0.2, 0.01, 0.02);
    for (std::uint32_t i = band; i < band + kFaces; ++i) {
      const std::uint32_t other = i + kFaces + 1;
      mesh.triangles.insert(mesh.triangles.end(), {{i, other, i + 1}, {other, other + 1, i + 1}});
    }
    for (std::uint32_t i = 1; i <= kCopies; ++i) {
      const double y = 1e-7 * i;
      const std::uint32_t apex = add({0.0, y, 0.0});
      add_faces(apex, add_arc(1.0, y));
    }
  }

  TriangleMesh mesh;

 private:
  std::uint32_t add(const Vec3& p) {
    mesh.vertices.push_back(p);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  }
  // Adds half a circle in the plane of this y, from x > 0 to x < 0, without `left_out` radians at both ends. Returns its first vertex.
  std::uint32_t add_arc(double radius, double y, double left_out = 0.0) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i <= kFaces; ++i) {
      const double angle = left_out + (std::numbers::pi - 2.0 * left_out) * i / kFaces;
      add({radius * std::cos(angle), y, radius * std::sin(angle)});
    }
    return first;
  }
  void add_faces(std::uint32_t apex, std::uint32_t first) {
    for (std::uint32_t i = first; i < first + kFaces; ++i) mesh.triangles.push_back({apex, i, i + 1});
  }
};

// A point on the floor that comes to the wall is lifted off, and goes on as a sphere. Gathering the triangles there takes all the work of a
// step. The next step goes on from the same position, and does not put the point back onto the floor to begin anew.
TEST(ProxyBesideACrowd, APointThatIsLiftedOffGoesOn) {
  const CrowdedWall crowd;
  TouchScene scene;
  scene.objects.push_back({std::make_shared<const TriangleMesh>(crowd.mesh), {}});
  const auto proxy = make_method({.name = "proxy"}, scene).value();
  for (int i = 0; i < 40; ++i) {
    const double x = 1e-9 * std::pow(1.2, i);
    proxy->reset({x + 0.12, -0.022, 0.1});
    for (const double beyond : {-1.0, -0.5, 0.0, 0.5}) {
      const Vec3 device(x - 0.1 * beyond, 0.02 * beyond, -0.02 - 0.01 * beyond);
      MethodOutput felt = proxy->step({.p_SD = device});
      for (int k = 0; proxy->carried_from() && k < 64; ++k) felt = proxy->step({.p_SD = device});
      ASSERT_FALSE(proxy->carried_from()) << "x " << x << ", beyond " << beyond;
      ASSERT_LE((felt.p_SP - Vec3(device.x(), std::min(device.y(), 0.0), 0.0)).norm(), 1e-8) << "x " << x << ", beyond " << beyond;
    }
  }
}

}  // namespace
}  // namespace hapton
