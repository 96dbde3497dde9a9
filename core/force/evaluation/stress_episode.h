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

// Motions of the device, each meant to break something.
enum class StressMotion : std::uint8_t {
  slide,          // over the surface, 1e-5 to 3e-2 of the extent a step, up to 3 % deep
  tap_face,       // straight in and out, 10 m/s and slower
  tap_vertex,     // exactly at vertices
  tap_edge,       // exactly at points of edges
  coincident,     // exactly in the plane of a triangle, over its corners and edges, then in
  near_parallel,  // through a face at an angle of 1e-1 down to 1e-15
  fast,           // jumps of up to the whole extent
  tiny,           // steps of 1e-12 to 1e-6 of the extent at and in the surface
  walk,           // a smooth random walk, in and out at random
  hostile,        // a walk with NaN, infinite and very distant samples
  count
};

std::string_view name_of(StressMotion motion);

// Episodes from this number on are long random walks: 20,000 steps over the whole body.
constexpr std::uint64_t kFirstLongWalk = 1ULL << 32;

// The device positions of one episode; a function of the constructor's arguments alone. RT: set-up only.
class StressEpisode {
 public:
  // inwards: the free side is the inside. Pre: mesh and walk outlive this object.
  StressEpisode(const TriangleMesh& mesh, SurfaceWalk& walk, double extent, bool inwards, std::uint64_t seed, std::string_view body,
                std::uint64_t number);

  StressMotion motion() const { return motion_; }

  // The positions of the episode; the method is reset at the first one. `is_free`: whether a position is on the free side.
  void draw(const std::function<bool(const Vec3&)>& is_free, std::vector<Vec3>& positions);

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
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
  void walk_near(std::vector<Vec3>& positions);
  // A long walk from one part of the body to the next, each time at another speed.
  void walk_over_body(std::vector<Vec3>& positions);
  // At a random speed, attracted gently to `at_`, which is on the surface.
  void random_walk(std::vector<Vec3>& positions, int steps);
  Vec3 hostile(Vec3 at);

  const TriangleMesh& mesh_;
  SurfaceWalk& walk_;
  double extent_;
  double side_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  StressMotion motion_;
  bool is_long_ = false;
  std::uint32_t triangle_ = 0;
  int corner_ = 0;
  Vec3 at_ = Vec3::Zero();
  Vec3 up_ = Vec3::UnitZ();
  Vec3 start_ = Vec3::Zero();
};

}  // namespace hapton
