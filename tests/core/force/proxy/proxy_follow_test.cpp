#include <gtest/gtest.h>

#include <memory>

#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {
namespace {

// A step of a slide in which a concave edge releases the point in mid-step and would hold it again at the end: if the device jumps to the
// end at once, the point stays.
struct LettingGo {
  unsigned seed;
  std::size_t step;
};

class ProxyFollow : public testing::TestWithParam<LettingGo> {
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

  // The output at the step, from the beginning of the slide's segment.
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

INSTANTIATE_TEST_SUITE_P(Slides, ProxyFollow, testing::Values(LettingGo{10, 9121}, LettingGo{18, 1387}),
                         [](const auto& test) { return "seed_" + std::to_string(test.param.seed); });

}  // namespace
}  // namespace hapton
