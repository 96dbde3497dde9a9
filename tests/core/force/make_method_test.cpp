#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/force/force_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(MakeMethod, BuildsTheSweep) {
  const auto method = make_method({.name = "sweep"}, {.objects = {{made::shared(made::sphere(0.1, 8)), {}}}});
  ASSERT_TRUE(method);
  EXPECT_NE((*method)->describe().find("sweep"), std::string::npos);
}

TEST(MakeMethod, AMeshWithoutTrianglesIsRejected) {
  TriangleMesh points;
  points.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  for (const char* name : {"proxy", "smooth", "sweep", "reference"}) {
    for (const TriangleMesh& mesh : {TriangleMesh(), points}) {
      const auto method = make_method({.name = name}, {.objects = {{made::shared(made::sphere(0.1, 8)), {}}, {made::shared(mesh), {}}}});
      ASSERT_FALSE(method) << name;
      EXPECT_NE(method.error().what.find("object 1 has no triangles"), std::string::npos) << method.error().what;
    }
  }
}

TEST(MakeMethod, AnUnknownNameIsRejectedWithTheKnownOnes) {
  const auto method = make_method({.name = "sweeep"}, {.objects = {{made::shared(made::sphere(0.1, 8)), {}}}});
  ASSERT_FALSE(method);
  EXPECT_NE(method.error().what.find("'sweeep'"), std::string::npos);
  EXPECT_NE(method.error().what.find("choose one of: "), std::string::npos);
  EXPECT_NE(method.error().what.find("sweep"), std::string::npos);
}

TEST(MakeMethod, AnImpossibleSettingIsRejectedInOneLineThatSaysWhatToGive) {
  const TouchScene ball{.objects = {{made::shared(made::sphere(0.1, 8)), {}}}};
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<MethodSettings, const char*>> cases = {
      {{.name = "smooth", .crease_deg = -1.0}, "crease angle of -1 degrees; give 0 to 180"},
      {{.name = "smooth", .crease_deg = 181.0}, "crease angle of 181 degrees; give 0 to 180"},
      {{.name = "smooth", .crease_deg = kNan}, "give 0 to 180"},
      {{.name = "smooth", .simplify_m = -1e-4}, "-0.0001 m is not from 0 to below the mesh's longest side, 0.2 m"},
      {{.name = "smooth", .simplify_m = 0.3}, "0.3 m is not from 0 to below the mesh's longest side, 0.2 m"},
      {{.name = "smooth", .simplify_m = kNan}, "longest side"},
      {{.name = "proxy", .crease_deg = 200.0}, "crease angle of 200 degrees; give 0 to 180"},
      {{.name = "proxy", .shading = 1.5}, "shading of 1.5; give 0 to 1"},
      {{.name = "proxy", .probe_radius_m = 1e30}, "probe radius of 1e+30 m; give 0 to"},
      {{.name = "proxy", .probe_radius_m = 1e3}, "probe radius of 1000 m; give 0 to"},
      {{.name = "proxy", .probe_radius_m = -1.0}, "probe radius of -1 m; give 0 to"},
      {{.name = "proxy", .probe_radius_m = kNan}, "give 0 to"},
      {{.name = "reference", .probe_radius_m = 1e30}, "probe radius of 1e+30 m; give 0 to"},
      {{.name = "reference", .probe_radius_m = kNan}, "give zero or more"},
  };
  for (const auto& [settings, words] : cases) {
    const auto method = make_method(settings, ball);
    ASSERT_FALSE(method) << words;
    EXPECT_NE(method.error().what.find(words), std::string::npos) << method.error().what;
    EXPECT_EQ(method.error().what.find('\n'), std::string::npos);
  }
}

TEST(MakeMethod, SmoothGetsItsCreaseAngleAndHowMuchToSimplify) {
  const TouchScene ball{.objects = {{made::shared(make_icosphere(0.05, 4)), {}}}};
  const auto plain = make_method({.name = "smooth"}, ball);
  const auto configured = make_method({.name = "smooth", .crease_deg = 63.0, .simplify_m = 2e-4}, ball);
  ASSERT_TRUE(plain && configured);
  EXPECT_NE((*plain)->describe().find("off, 5120 triangles"), std::string::npos) << (*plain)->describe();
  EXPECT_NE((*plain)->describe().find("more than 40 degrees"), std::string::npos);
  EXPECT_NE((*configured)->describe().find("5120 triangles made "), std::string::npos) << (*configured)->describe();
  EXPECT_NE((*configured)->describe().find("more than 63 degrees"), std::string::npos);
}

TEST(MakeMethod, ASphereProbeIsAcceptedWhereSupportsSpheresSaysSo) {
  const TouchScene ball{.objects = {{made::shared(made::sphere(0.1, 8)), {}}}};
  for (const char* name : {"proxy", "reference", "smooth", "sweep"}) {
    ASSERT_TRUE(is_method_name(name)) << name;
    EXPECT_EQ(make_method({.name = name, .probe_radius_m = 1e-3}, ball).has_value(), supports_spheres(name)) << name;
  }
  EXPECT_TRUE(supports_spheres("proxy"));
  EXPECT_FALSE(supports_spheres("none"));
}

TEST(MakeMethod, EmptySceneIsRejected) {
  EXPECT_FALSE(make_method({}, {}));
  EXPECT_FALSE(make_method({}, {.objects = {{nullptr, {}}}}));
}

}  // namespace
}  // namespace hapton
