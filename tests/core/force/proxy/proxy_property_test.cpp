#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/touch_trajectory.h"
#include "tests/support/obj_mesh.h"

// Properties of the proxy that hold on every mesh of a kind, tested with random ones.
namespace hapton {
namespace {

std::unique_ptr<ForceMethod> proxy_over(const TriangleMesh& mesh, double radius_m = 0.0) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(mesh), {}});
  MethodSettings settings;
  settings.probe_radius_m = radius_m;
  return ProxyMethod::make(settings, scene).value();
}

struct Room {
  std::string name;
  TriangleMesh walls;
  Vec3 middle = Vec3::Zero();
};

Room turned(Room room, const Pose& pose) {
  for (Vec3& v : room.walls.vertices) v = pose * v;
  room.middle = pose * room.middle;
  room.name = "turned " + room.name;
  return room;
}

// How far outside of a convex room p is; negative inside.
double height_outside(const Room& room, const Vec3& p) {
  double highest = -1.0;
  for (const Triangle& t : room.walls.triangles) {
    const Vec3& a = room.walls.vertices[t[0]];
    const Vec3 normal = (room.walls.vertices[t[1]] - a).cross(room.walls.vertices[t[2]] - a).normalized();
    highest = std::max(highest, normal.dot(p - a));
  }
  return highest;
}

bool is_convex(const Room& room, double rounding) {
  return std::all_of(room.walls.vertices.begin(), room.walls.vertices.end(),
                     [&](const Vec3& v) { return height_outside(room, v) <= rounding; });
}

// Steps of all lengths in a room, through its walls and back.
class RoomWanderer {
 public:
  RoomWanderer(const Room& room, double depth, std::uint64_t seed)
      : random_(seed), middle_(room.middle), at_(room.middle), bounds_(compute_bounds(room.walls)), depth_(depth) {}

  const Vec3& next() {
    const double length = std::pow(10.0, uniform(-7.0, -1.5)) * bounds_.extent();
    Vec3 to = at_ + length * Vec3(normal_(random_), normal_(random_), normal_(random_));
    if (random_() % 2000 == 0) to = middle_;
    at_ = to.cwiseMax(bounds_.low - Vec3::Constant(depth_)).cwiseMin(bounds_.high + Vec3::Constant(depth_));
    return at_;
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Vec3 middle_;
  Vec3 at_;
  MeshBounds bounds_;
  double depth_;
};

std::vector<Room> rooms() {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Vec3(0.3, -0.2, 0.1);
  const Room box{"box of two triangles a side", make_box({0.1, 0.08, 0.06}, 1)};
  const Room fine{"box of 7 x 7 squares a side", make_box({0.1, 0.08, 0.06}, 7)};
  const Room ball{"ball", make_icosphere(0.05, 3)};
  const Room fine_ball{"finer ball", make_icosphere(0.05, 4)};
  const Room can{"cylinder", make_cylinder(0.04, 0.1, 24, 3)};
  return {box, turned(box, pose), fine, turned(fine, pose), ball, fine_ball, can, turned(can, pose)};
}

// In convex free space the proxy is the device's projection: neither it nor the force moves by more than the device does, so there is no
// force discontinuity. What remains is the contact offset, a share of the room's size, and that the proxy stops at 2^-24 of the depth from
// the minimum (the accuracy of a normal at the distance of the contact offset).
TEST(ProxyProperty, InAConvexRoomTheProxyMovesNoFartherThanTheDevice) {
  constexpr double kContactOffsetShare = 4e-9;
  constexpr double kRestShare = 0x1p-24;
  constexpr double kStiffness = 1000.0;
  std::uint64_t seed = 4040;
  for (const Room& room : rooms()) {
    ASSERT_TRUE(is_convex(room, 1e-15)) << room.name;
    const double extent = compute_bounds(room.walls).extent();
    for (const double radius : {0.0, 0.003, 0.02}) {
      ++seed;
      SCOPED_TRACE(testing::Message() << room.name << ", probe radius " << radius << ", seed " << seed);
      const auto proxy = proxy_over(room.walls, radius);
      RoomWanderer wanderer(room, 0.2 * extent, seed);
      Vec3 device = room.middle;
      proxy->reset(device);
      MethodOutput last = proxy->step({.p_SD = device});
      int contacts = 0;
      int failures = 0;
      for (int i = 0; i < 20000 && failures < 3; ++i) {
        const Vec3 next = wanderer.next();
        MethodOutput felt = proxy->step({.p_SD = next});
        for (int k = 0; k < 100 && proxy->carried_from(); ++k) felt = proxy->step({.p_SD = next});  // out of work: to the end of the motion
        const double moved = (next - device).norm();
        const double excess = (felt.p_SP - last.p_SP).norm() - moved;
        const double force_excess = (felt.force_n - last.force_n).norm() / kStiffness - moved;
        const double rounding = kContactOffsetShare * extent + kRestShare * ((last.p_SP - device).norm() + (felt.p_SP - next).norm());
        if (excess > rounding || force_excess > rounding) {
          ++failures;
          ADD_FAILURE() << "step " << i << " moved " << moved << ", proxy " << excess << " farther, force " << force_excess
                        << " farther; from " << device.transpose() << " (proxy " << last.p_SP.transpose() << ") to " << next.transpose()
                        << " (proxy " << felt.p_SP.transpose() << ")";
        }
        if (i % 64 == 0) {
          EXPECT_LE(height_outside(room, felt.p_SP), 1e-12 - radius) << "it left the room at step " << i;
        }
        contacts += felt.contact ? 1 : 0;
        device = next;
        last = felt;
      }
      EXPECT_GT(contacts, 1000);
    }
  }
}

struct Reordering {
  const char* name;
  void (*apply)(TriangleMesh& mesh, std::mt19937_64& random);
};

void shuffle_triangles(TriangleMesh& mesh, std::mt19937_64& random) { std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random); }

void rotate_corners(TriangleMesh& mesh, std::mt19937_64& random) {
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), t.begin() + static_cast<int>(random() % 3), t.end());
}

void renumber_vertices(TriangleMesh& mesh, std::mt19937_64& random) {
  std::vector<std::uint32_t> to(mesh.vertices.size());
  std::iota(to.begin(), to.end(), 0U);
  std::shuffle(to.begin(), to.end(), random);
  const std::vector<Vec3> vertices = mesh.vertices;
  for (std::size_t v = 0; v < to.size(); ++v) mesh.vertices[to[v]] = vertices[v];
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = to[v];
  }
}

void reverse_half(TriangleMesh& mesh, std::mt19937_64& random) {
  for (Triangle& t : mesh.triangles) {
    if (random() % 2 == 0) std::swap(t[1], t[2]);
  }
}

constexpr std::array kReorderings = {
    Reordering{"triangles in another order", shuffle_triangles},
    Reordering{"corners turned", rotate_corners},
    Reordering{"vertices in another order", renumber_vertices},
    Reordering{"half of the triangles reversed", reverse_half},
    Reordering{"every triangle reversed", [](TriangleMesh& mesh, std::mt19937_64&) { mesh = flipped(std::move(mesh)); }},
    Reordering{"all of it",
               [](TriangleMesh& mesh, std::mt19937_64& random) {
                 for (const auto apply : {shuffle_triangles, rotate_corners, renumber_vertices, reverse_half}) apply(mesh, random);
               }},
};

// A two-sided surface is the same in any order and orientation of its triangles, so every force must be the same.
TEST(ProxyProperty, TheForceIsTheSameWhateverTheOrderAndTheWinding) {
  constexpr double kRestShare = 0x1p-23;  // of the force: two settled proxies at the same minimum (above)
  constexpr std::uint64_t kSeed = 99;
  for (const TriangleMesh& mesh :
       {make_bumpy_sphere(0.05, 0.05, 3000, 2), make_bumpy_sphere(0.05, 0.2, 3000, 5), made::obj_mesh("wingnut.obj")}) {
    const auto slide = make_slide_trajectory(mesh, {.seed = kSeed, .rows = 1500}).value();
    const auto feel = [&](const TriangleMesh& listed, double radius) {
      const auto proxy = proxy_over(listed, radius);
      std::vector<Vec3> forces;
      for (std::size_t i = 0; i < slide.p_SD.size(); ++i) {
        if (i == 0 || (slide.reset_every > 0 && i % slide.reset_every == 0)) proxy->reset(slide.p_SD[i]);
        forces.push_back(proxy->step({.p_SD = slide.p_SD[i]}).force_n);
      }
      return forces;
    };
    for (const double share : {0.0, 0.02}) {
      const double radius = share * compute_bounds(mesh).extent();
      const auto expected = feel(mesh, radius);
      for (const Reordering& reordering : kReorderings) {
        SCOPED_TRACE(testing::Message() << mesh.triangles.size() << " triangles, " << reordering.name << ", probe radius " << radius
                                        << ", seed " << kSeed);
        std::mt19937_64 random(kSeed);
        TriangleMesh other = mesh;
        reordering.apply(other, random);
        const auto felt = feel(other, radius);
        int contacts = 0;
        for (std::size_t i = 0; i < felt.size(); ++i) {
          ASSERT_LE((felt[i] - expected[i]).norm(), kRestShare * expected[i].norm() + 1e-9) << "step " << i;
          contacts += expected[i].isZero(0.0) ? 0 : 1;
        }
        EXPECT_GT(contacts, 500);
      }
    }
  }
}

}  // namespace
}  // namespace hapton
