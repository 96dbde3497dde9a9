#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string_view>
#include <vector>

#include "core/geometry/surface_walk.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Motions of the device, each of which provokes another kind of fault. Extent: longest side of the body. Units are those of the mesh.
enum class StressMotion : std::uint8_t {
  slide,          // over the surface, 1e-5 to 3e-2 of the extent a step, at a depth of up to 5.4 % of the extent
  tap_face,       // at points of faces, straight in and out, up to 10 % of the extent a step
  tap_vertex,     // the same exactly at vertices
  tap_edge,       // the same exactly at points of edges
  coincident,     // in the plane of a triangle, exactly or nearly, through its corners and edges, then below it
  near_parallel,  // through a face at an angle of 1e-1 down to 1e-15 rad
  fast,           // jumps to points up to twice the extent from the first one
  tiny,           // steps of 1e-12 to 1e-6 of the extent at the surface and below it
  walk,           // a smooth random walk that crosses the surface in and out
  hostile,        // a walk with NaN, infinite and very distant samples
  count
};

std::string_view name_of(StressMotion motion);

// Episodes from this number on are long random walks: 20,000 steps over the whole body.
constexpr std::uint64_t kFirstLongWalk = 1ULL << 32;

// The device positions of one episode, determined by the constructor's arguments and is_free alone. RT: set-up only.
class StressEpisode {
 public:
  // extent: longest side of the mesh. is_free_outside: free space is on the side of the triangles' normals; false for a hollow room. body:
  // its name, part of the seed. Pre: mesh and walk outlive this object.
  StressEpisode(const TriangleMesh& mesh, SurfaceWalk& walk, double extent, bool is_free_outside, std::uint64_t seed, std::string_view body,
                std::uint64_t number);

  StressMotion motion() const { return motion_; }

  // Replaces `positions` by those of the episode; the caller resets the method at the first one. is_free: whether a position is surely in
  // free space; if none of the 32 that are tried is, the first one is not free. Call once.
  void draw(const std::function<bool(const Vec3&)>& is_free, std::vector<Vec3>& positions);

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  // 10^x with x uniform between low and high: any order of magnitude is equally likely.
  double log_uniform(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  double normal() { return normal_(random_); }
  Vec3 direction();
  void choose_position();
  void go_to(std::vector<Vec3>& positions, const Vec3& to, double step);
  void slide(std::vector<Vec3>& positions);
  void tap(std::vector<Vec3>& positions);
  void coincide(std::vector<Vec3>& positions);
  void graze(std::vector<Vec3>& positions);
  void jump(std::vector<Vec3>& positions);
  void creep(std::vector<Vec3>& positions);
  // One random walk after the other, each near another point of the body and at a speed of its own.
  void walk_over_body(std::vector<Vec3>& positions);
  // A random walk (Ornstein-Uhlenbeck velocity) at a random speed, attracted gently to surface_point_.
  void random_walk(std::vector<Vec3>& positions, int steps);
  Vec3 hostile(Vec3 at);

  const TriangleMesh& mesh_;
  SurfaceWalk& walk_;
  double extent_;
  double side_;  // 1: free space is on the side of the normals; -1: on the other side
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  StressMotion motion_;
  bool is_long_ = false;
  std::uint32_t triangle_ = 0;
  int corner_ = 0;
  Vec3 surface_point_ = Vec3::Zero();  // a point on the surface
  Vec3 up_ = Vec3::UnitZ();            // unit normal at surface_point_, towards free space
  Vec3 start_ = Vec3::Zero();          // first position, in free space
};

}  // namespace hapton
