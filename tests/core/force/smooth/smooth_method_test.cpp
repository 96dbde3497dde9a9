#include "core/force/smooth/smooth_method.h"

#include <gtest/gtest.h>

#include "tests/core/force/smooth/smooth_scenes.h"

namespace hapton {
namespace {

TEST(SmoothMethod, FewerTrianglesChangeTheForceByNoMoreThanTheBoundExplains) {
  constexpr double kBound = 2e-4;
  constexpr double kSheetStiffness = 1000.0;
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TouchScene scene = scene_of(make_icosphere(0.05, 5), {.stiffness_n_per_m = kSheetStiffness});
  const auto all = make_with_crease(scene, 40.0, 0.0);
  const auto fewer = make_with_crease(scene, 40.0, kBound);
  const auto faces = [](const ForceMethod& method) { return dynamic_cast<const SmoothMethod&>(method).scene().surface(0).face_count; };
  EXPECT_LT(faces(*fewer), faces(*all) / 4);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 300; ++i) {
    const Vec3 out = Vec3(normal(random), normal(random), normal(random)).normalized();
    MethodOutput expected;
    MethodOutput felt;
    all->reset(0.051 * out);
    fewer->reset(0.051 * out);
    for (int step = 1; step <= 30; ++step) {
      const Vec3 P = (0.051 - 1e-4 * step) * out;
      expected = all->step({.p_SD = P});
      felt = fewer->step({.p_SD = P});
    }
    ASSERT_GT(expected.force_n.norm(), 1.9);
    EXPECT_NEAR(felt.force_n.norm(), expected.force_n.norm(), kSheetStiffness * kBound);
  }
}

TEST(SmoothMethod, TheCreaseAngleRoundsABoxesEdges) {
  const TouchScene scene = scene_of(make_box(Vec3::Constant(0.1), 8));
  const auto press_near_edge = [&](double crease_deg) {
    const auto method = make_with_crease(scene, crease_deg, 0.0);
    MethodOutput felt;
    method->reset(Vec3(0.048, 0.001, 0.052));
    for (int i = 0; i <= 30; ++i) felt = method->step({.p_SD = Vec3(0.048, 0.001, 0.052 - 1e-4 * i)});
    return felt.force_n;
  };
  EXPECT_LT(angle_between(press_near_edge(40.0), Vec3::UnitZ()), 1e-6);
  EXPECT_GT(angle_between(press_near_edge(120.0), Vec3::UnitZ()), 0.3);
}

TEST(SmoothMethod, PressingAPlaneGivesHookesLaw) {
  const auto method = make_smooth(scene_of(make_plane_grid(0.1, 20), {.stiffness_n_per_m = 700.0}));
  method->reset(Vec3(0.0013, 0.0021, 0.004));
  for (int i = 0; i <= 100; ++i) {
    const Vec3 P(0.0013 + 1e-4 * i, 0.0021, 0.004 - 6e-5 * i);
    const MethodOutput felt = method->step({.p_SD = P});
    if (P.z() > 1e-6) {
      EXPECT_TRUE(felt.force_n.isZero(0.0));
      EXPECT_FALSE(felt.contact);
      EXPECT_EQ(felt.p_SP, P);
    } else if (P.z() < -1e-6) {
      EXPECT_LT((felt.force_n - Vec3(0, 0, -700.0 * P.z())).norm(), kOffsetForce) << i;
      EXPECT_LT((felt.p_SP - Vec3(P.x(), P.y(), 0)).norm(), kContactOffset);
      EXPECT_TRUE(felt.contact);
    }
  }
  EXPECT_EQ(method->counters().entries, 1U);
}

TEST(SmoothMethod, APlaneIsTouchedFromEitherSideUnlessOneSided) {
  for (const bool two_sided : {true, false}) {
    const auto method = make_smooth(scene_of(make_plane_grid(0.1, 20), {.two_sided = two_sided}));
    for (const double side : {1.0, -1.0}) {
      method->reset(Vec3(0.001, 0.002, side * 0.001));
      const MethodOutput felt = method->step({.p_SD = Vec3(0.001, 0.002, -side * 0.002)});
      const double expected = two_sided || side > 0.0 ? side * 2.0 : 0.0;
      EXPECT_NEAR(felt.force_n.z(), expected, kOffsetForce);
    }
  }
}

// Inside a sphere the force is far nearer to radial than the facet normals, and turns evenly as the probe moves round: no jumps at edges.
TEST(SmoothMethod, InsideASphereTheForceIsRadialAndEven) {
  constexpr double kRadius = 0.05;
  const TriangleMesh mesh = make_icosphere(kRadius, 3);
  const auto method = make_smooth(scene_of(mesh));
  double facet_error = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    for (int k = 0; k < 3; ++k) facet_error = std::max(facet_error, angle_between(n, mesh.corner(t, k)));
  }
  method->reset(Vec3(kRadius * 1.1, 0, 0));
  constexpr int kSteps = 20000;
  Vec3 last;
  Vec3 last_P;
  double worst_angle = 0.0;
  double worst_turn = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double a = 2.0 * std::numbers::pi * i / kSteps;
    const Vec3 P = (kRadius - 0.0015) * Vec3(std::cos(a), 0.8 * std::sin(a), 0.6 * std::sin(a));
    const MethodOutput felt = method->step({.p_SD = P});
    ASSERT_TRUE(felt.contact) << "fell through at step " << i;
    worst_angle = std::max(worst_angle, angle_between(felt.force_n, P));
    if (i > 0) worst_turn = std::max(worst_turn, angle_between(felt.force_n, last) / angle_between(P, last_P));
    last = felt.force_n;
    last_P = P;
    EXPECT_NEAR(felt.force_n.norm(), 1.5, 0.5);
  }
  EXPECT_LT(worst_angle, 0.3 * facet_error);
  EXPECT_LT(worst_turn, 3.0);
  EXPECT_EQ(method->counters().entries, 1U);
}

// With a layer the force builds up before the surface and continues behind it, without a discontinuity on the surface.
TEST(SmoothMethod, TheLayerIsContinuousThroughTheSurface) {
  for (const TriangleMesh& mesh : {make_icosphere(0.05, 3), make_box(Vec3(0.07, 0.07, 0.07), 3)}) {
    const auto method = make_smooth(scene_of(mesh), {.smooth_layer = 1.0});
    const Vec3 inward = -Vec3(0.3, 0.25, 1.0).normalized();
    const double from = 0.053;
    method->reset(-from * inward);
    double last_n = 0.0;
    bool has_begun = false;
    constexpr double kStep = 2e-6;
    for (double travelled = kStep; travelled < from - 0.03; travelled += kStep) {
      const Vec3 P = -(from - travelled) * inward;
      const double force = method->step({.p_SD = P}).force_n.norm();
      EXPECT_LE(std::fabs(force - last_n), 1000.0 * kStep * 1.6) << "at " << P.transpose();
      if (force > 0.0) has_begun = true;
      if (has_begun) {
        EXPECT_GT(force, 0.0);
      }
      last_n = force;
    }
    EXPECT_GT(last_n, 1000.0 * method->radius_m());
    EXPECT_EQ(method->counters().entries, 1U);
  }
}

TEST(SmoothMethod, SettingsAreChecked) {
  const TouchScene scene = scene_of(make_icosphere(0.05, 1));
  MethodSettings settings;
  settings.name = "smooth";
  EXPECT_TRUE(make_method(settings, scene));
  const auto is_rejected = [&](const std::function<void(MethodSettings&)>& change) {
    MethodSettings wrong = settings;
    change(wrong);
    const auto made = make_method(wrong, scene);
    return !made && made.error().what.find("smooth") != std::string::npos;
  };
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.set_size = 15; }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.set_size = 257; }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.smooth_radius_m = -1.0; }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.smooth_radius_m = std::nan(""); }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.smooth_layer = 1.5; }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.hull_directions = 8; }));
  EXPECT_TRUE(is_rejected([](MethodSettings& s) { s.probe_radius_m = 0.001; }));
}

TEST(SmoothMethod, DescribesWhatItDid) {
  const auto method = make_smooth(scene_of(make_icosphere(0.05, 2)));
  method->reset(Vec3(0.06, 0, 0));
  method->step({.p_SD = Vec3(0.049, 0, 0)});
  const std::string text = method->describe();
  for (const char* word : {"RADIUS", "repair:", "hulls of 14", "1 entries", "selected here"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
}

// The line of the description that says what a method with a layer leaves out; empty if there is no such line.
std::string note_of_layer(const std::vector<TouchObject>& objects) {
  TouchScene scene{.objects = objects};
  for (TouchObject& object : scene.objects) object.mesh = made::shared(make_icosphere(0.05, 0));
  const std::string text = make_smooth(scene, with_size(64, 1.0))->describe();
  const std::size_t begin = text.find("note: ");
  if (begin == std::string::npos) return {};
  EXPECT_EQ(text.find("note: ", begin + 1), std::string::npos) << text;
  return text.substr(begin, text.find('\n', begin) - begin);
}

TEST(SmoothMethod, CountsObjectsWithEffectsFrictionOrDampingForALayer) {
  EXPECT_EQ(note_of_layer({TouchObject{}}), "");
  for (const Material& material : {Material{.damping_ns_per_m = 0.1}, Material{.friction_static = 0.1, .friction_dynamic = 0.1}}) {
    const std::string note = note_of_layer({{}, {.mesh = {}, .material = material}});
    EXPECT_EQ(note.find("note: 1 of 2 objects: their effects, damping and friction begin at the surface"), 0U) << note;
  }
  const std::string text = note_of_layer({{.mesh = {}, .material = {}, .effects = {.viscosity = {.damping_ns_per_m = 4}}}});
  EXPECT_EQ(text.find("note: 1 of 1 object: their effects, damping and friction begin at the surface"), 0U) << text;
}

TEST(SmoothMethod, LeavesDampingAndFrictionOfTheMaterialsInUseToItsStep) {
  const auto method = make_smooth(scene_of(make_icosphere(0.05, 1), {.friction_static = 0.5}));
  ASSERT_EQ(method->unrendered_drag().size(), 1U);
  EXPECT_EQ(method->unrendered_drag()[0].friction_static, 0.5);
  const Material other = {.damping_ns_per_m = 2.0};
  method->set_materials({&other, 1});
  EXPECT_EQ(method->unrendered_drag()[0].friction_static, 0.0);
  EXPECT_EQ(method->unrendered_drag()[0].damping_ns_per_m, 2.0);
}

}  // namespace
}  // namespace hapton
