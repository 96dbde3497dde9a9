// Each baseline in cases whose result is known by hand.
#include "remote_touch/remote_methods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "remote_touch/remote_law.h"
#include "remote_touch/remote_patch.h"
#include "remote_touch/whole_scene.h"
#include "tests/support/made_meshes.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr double kSheetNPerM = 1000.0;

// The hand presses 2 mm into a wavy or flat sheet, and moves in circles.
Vec3 hand_at(int row, double surface_z_m) {
  const double t_s = 1e-3 * row;
  const double press = std::clamp((t_s - 0.2) / 0.2, 0.0, 1.0);
  return {0.02 * std::cos(4.0 * t_s), 0.02 * std::sin(4.0 * t_s), surface_z_m + 0.01 * (1.0 - press) - 0.002 * press};
}

TriangleMesh wavy_sheet() {
  TriangleMesh mesh = made::sheet(0.05, 0.0, 60);
  for (Vec3& v : mesh.vertices) v.z() = 0.001 * std::sin(270.0 * v.x()) * std::sin(220.0 * v.y());
  return mesh;
}

RemoteScene scene_of(TriangleMesh mesh) { return *make_remote_scene(made::shared(std::move(mesh)), {.stiffness_n_per_m = kSheetNPerM}); }

struct Rows {
  std::vector<Vec3> force_n;
  std::vector<Vec3> zero_delay_n;
};

// Steps the method until it has what it needs; only then the hand comes down.
Rows run(std::string_view name, const RemoteScene& scene, const RemoteNetwork& network, const RemoteSettings& settings = {}) {
  const auto touch = make_remote_touch(*find_remote_method(name), scene, network, settings);
  WholeScene whole(scene.zero_delay_method);
  Rows rows;
  std::int64_t now_ns = 1000 * kMs;
  for (int waited = 0; waited < 20000 && !touch->is_ready(); ++waited) (void)touch->step(hand_at(0, 0.0), now_ns += kMs);
  for (int row = 0; row < 2000; ++row) {
    now_ns += kMs;
    rows.force_n.push_back(touch->step(hand_at(row, 0.0), now_ns).force_n);
    rows.zero_delay_n.push_back(whole.step(hand_at(row, 0.0), now_ns).force_n);
  }
  return rows;
}

double max_error_n(const Rows& rows, std::size_t late_rows = 0) {
  double worst = 0.0;
  for (std::size_t i = late_rows; i < rows.force_n.size(); ++i)
    worst = std::max(worst, (rows.force_n[i] - rows.zero_delay_n[i - late_rows]).norm());
  return worst;
}

double error_rms(const Rows& rows) {
  double error_squares = 0.0;
  double force_squares = 0.0;
  for (std::size_t i = 0; i < rows.force_n.size(); ++i) {
    error_squares += (rows.force_n[i] - rows.zero_delay_n[i]).squaredNorm();
    force_squares += rows.zero_delay_n[i].squaredNorm();
  }
  return std::sqrt(error_squares / force_squares);
}

TEST(RemoteMethods, AreKnownByTheirNames) {
  for (const RemoteMethod& method : remote_methods()) {
    EXPECT_EQ(find_remote_method(method.name), &method);
    EXPECT_NE(remote_method_names().find(method.name), std::string::npos);
  }
  EXPECT_EQ(find_remote_method("nothing"), nullptr);
}

TEST(RemoteMethods, WithoutDelayAndLossAllGiveTheZeroDelayForce) {
  const RemoteScene scene = scene_of(wavy_sheet());
  for (const RemoteMethod& method : remote_methods()) {
    SCOPED_TRACE(method.name);
    // The grid rounds the vertices of a patch, so the proxy crosses an edge a step earlier or later. A deadband hides a tenth of the force,
    // and a tenth of a millimetre of the position, where the slope may already be another.
    const double bound_n = method.scheme == RemoteMethod::Scheme::patch ? 0.05
                           : method.scheme == RemoteMethod::Scheme::deadband
                               ? 0.1 * 3.0 + 2.0 * 0.1 * kSheetNPerM * RemoteDeadband::kPositionM
                               : 1e-9;
    const Rows rows = run(method.name, scene, {});
    EXPECT_LT(max_error_n(rows), bound_n);
    if (method.scheme == RemoteMethod::Scheme::patch) {
      EXPECT_LT(error_rms(rows), 1e-3);
    }
    EXPECT_GT(rows.zero_delay_n.back().norm(), 1.0) << "there is contact";
  }
}

TEST(RemoteMethods, RemoteForceIsTheZeroDelayForceARoundTripLater) {
  const RemoteScene scene = scene_of(wavy_sheet());
  const Rows rows = run("remote-held", scene, RemoteNetwork::of(0.04, 0.0, 0.0, 1));
  EXPECT_LT(max_error_n(rows, 40), 1e-9);
  EXPECT_GT(max_error_n(rows), 0.3);
}

TEST(RemoteMethods, ADeadbandOfFractionZeroIsRemoteForce) {
  const RemoteScene scene = scene_of(wavy_sheet());
  for (const char* name : {"deadband", "deadband-linear"}) {
    EXPECT_LT(max_error_n(run(name, scene, RemoteNetwork::of(0.04, 0.0, 0.0, 1), {.deadband = 0.0}), 40), 1e-9) << name;
  }
}

TEST(RemoteMethods, ADeadbandSendsFewerPacketsForAFractionOfTheForce) {
  const RemoteScene scene = scene_of(wavy_sheet());
  const auto packets_of = [&](double fraction) {
    const auto touch = make_remote_touch(*find_remote_method("deadband"), scene, {}, {.deadband = fraction});
    for (int row = 0; row < 2000; ++row) (void)touch->step(hand_at(row, 0.0), (1000 + row) * kMs);
    return touch->traffic();
  };
  const RemoteTraffic all = packets_of(0.0);
  const RemoteTraffic coded = packets_of(0.1);
  EXPECT_EQ(all.up.packets, 2000U);
  EXPECT_EQ(all.down.packets, 2000U);
  EXPECT_LT(coded.up.packets, 1000U);
  EXPECT_LT(coded.down.packets, 500U);
  EXPECT_GT(coded.down.packets, 10U);
}

TEST(RemoteMethods, OnePlaneIsExactOnAFlatFaceAndOnlyThere) {
  const RemoteNetwork network = RemoteNetwork::of(0.06, 0.1, 0.0, 1);
  const Rows flat = run("plane", scene_of(made::sheet(0.05, 0.0, 10)), network);
  // Compares the rows from 500 on, when the first plane has arrived.
  double worst = 0.0;
  for (std::size_t i = 500; i < flat.force_n.size(); ++i) worst = std::max(worst, (flat.force_n[i] - flat.zero_delay_n[i]).norm());
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(max_error_n(run("plane", scene_of(wavy_sheet()), network)), 0.3);
}

TEST(RemoteMethods, PatchesGiveTheZeroDelayForceAtAnyDelay) {
  const RemoteScene scene = scene_of(wavy_sheet());
  EXPECT_LT(error_rms(run("patch", scene, RemoteNetwork::of(1.0, 0.3, 0.02, 1))), 1e-3);
}

// The governor releases a force 20 ms after its sample: with a shorter round trip it lets the force through, with a longer one it does not.
TEST(RemoteLaw, TheGovernorReleasesAForceOfAnOldSample) {
  const RemoteScene scene = scene_of(made::sheet(0.05, 0.0, 10));
  const RemoteMethod& method = *find_remote_method("remote");
  for (const double round_trip_s : {0.01, 0.03}) {
    RemoteLaw law(method, make_remote_touch(method, scene, RemoteNetwork::of(round_trip_s, 0.0, 0.0, 1), {}),
                  {.limits = {.max_force_n = 8.0, .max_slew_n_per_s = 2000.0}, .mechanics = {.mass_kg = 0.1}}, kMs);
    Vec3 force_n = Vec3::Zero();
    for (int row = 0; row < 1000; ++row) force_n = law.step(hand_at(row, 0.0), 1e-3);
    EXPECT_NEAR(force_n.z(), round_trip_s < 0.02 ? 2.0 : 0.0, 1e-6);
  }
}

TEST(RemoteLaw, WaitsUntilTheSceneIsThereAndGivesUp) {
  const RemoteScene scene = scene_of(wavy_sheet());
  const RemoteMethod& method = *find_remote_method("patch");
  const auto wait_with_loss = [&](double loss) {
    RemoteLaw law(method, make_remote_touch(method, scene, RemoteNetwork::of(0.1, loss, 0.0, 1), {}), {}, kMs);
    return law.wait(Vec3(0.0, 0.0, 0.01), 0.1, 10.0);
  };
  ASSERT_TRUE(wait_with_loss(0.0));
  EXPECT_GT(*wait_with_loss(0.0), 0.5);
  EXPECT_LT(*wait_with_loss(0.0), 5.0);
  EXPECT_FALSE(wait_with_loss(1.0)) << "no packet arrives";
}

}  // namespace
}  // namespace hapton
