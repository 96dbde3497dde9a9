#include "core/force/stress_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

#include "core/force/certain_rest.h"
#include "core/force/reference_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/point_in_mesh.h"
#include "core/geometry/surface_walk.h"

namespace hapton {
namespace {

constexpr double kFallShare = 0.0025;
constexpr double kInsideShare = 1e-6;  // above what a probe hovers by and what a million extents of offset round to
constexpr double kLockShare = 0.10;
constexpr double kLockGain = 0.01;
constexpr double kLagGain = 0.001;
constexpr double kTieShare = 1e-6;
constexpr double kOutsideShare = 1e-7;
constexpr double kMouthShare = 1e-5;  // at the mouth of a crack: where it is narrower than one of the two hovers, only the other gets in
constexpr double kRestHovers = 4.0;   // round a rest that may be proved to be one
constexpr double kThroughStep = 0.01;
constexpr double kRelative = 4e-9;        // a method may hover by this share of the extent and leave that out of the force
constexpr std::size_t kMostFindings = 1;  // of each fault in each motion
constexpr std::size_t kLongestEpisode = 400;
constexpr int kWalkSteps = 390;
constexpr int kLongWalkLegs = 20;
constexpr int kLongWalkLegSteps = 1000;

std::uint64_t hash_of(std::string_view text) {  // FNV-1a
  std::uint64_t hash = 1469598103934665603ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

// The device positions of one episode, drawn step by step.
class Episode {
 public:
  Episode(const TriangleMesh& mesh, SurfaceWalk& walk, double extent, bool inwards, std::uint64_t seed, std::string_view body,
          std::uint64_t number)
      : mesh_(mesh), walk_(walk), extent_(extent), side_(inwards ? 1.0 : -1.0) {
    const std::uint64_t name = hash_of(body);
    std::seed_seq sequence{seed, seed >> 32, name, name >> 32, number, number >> 32};
    random_.seed(sequence);
    motion_ = static_cast<StressMotion>(random_() % static_cast<std::uint64_t>(StressMotion::kCount));
    is_long_ = number >= kFirstLongWalk;
    if (is_long_) motion_ = StressMotion::kWalk;
  }

  StressMotion motion() const { return motion_; }

  // The places of the episode; the first is where the method is reset. `is_free` says whether a place is on the free side.
  template <class IsFree>
  void draw(IsFree is_free, std::vector<Vec3>& places) {
    places.clear();
    for (int i = 0; i < 32; ++i) {
      choose_place();
      start_ = at_ + 0.05 * extent_ * up_;
      if (is_free(start_)) break;
    }
    places.push_back(start_);
    if (is_long_) return travel(places);
    switch (motion_) {
      case StressMotion::kSlide:
        slide(places);
        break;
      case StressMotion::kTapFace:
      case StressMotion::kTapVertex:
      case StressMotion::kTapEdge:
        tap(places);
        break;
      case StressMotion::kCoincident:
        coincide(places);
        break;
      case StressMotion::kNearParallel:
        graze(places);
        break;
      case StressMotion::kFast:
        jump(places);
        break;
      case StressMotion::kTiny:
        creep(places);
        break;
      default:
        wander(places);
        break;
    }
    if (places.size() > kLongestEpisode) places.resize(kLongestEpisode);
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double power(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  double normal() { return normal_(random_); }
  Vec3 direction() {
    Vec3 v(normal(), normal(), normal());
    return v.norm() > 0.0 ? Vec3(v.normalized()) : Vec3(Vec3::UnitX());
  }

  void choose_place() {
    for (int i = 0; i < 64; ++i) {
      triangle_ = static_cast<std::uint32_t>(random_() % mesh_.triangles.size());
      if (walk_.has_area(triangle_)) break;
    }
    corner_ = static_cast<int>(random_() % 3);
    const Vec3 &a = mesh_.corner(triangle_, corner_), &b = mesh_.corner(triangle_, (corner_ + 1) % 3),
               &c = mesh_.corner(triangle_, (corner_ + 2) % 3);
    const Vec3 n = (b - a).cross(c - a);
    up_ = n.squaredNorm() > 0.0 ? Vec3(side_ * n.normalized()) : direction();
    double u = uniform(0.0, 1.0), v = uniform(0.0, 1.0);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const double quarter = static_cast<double>(1 + random_() % 3) / 4.0;
    at_ = motion_ == StressMotion::kTapVertex ? a
          : motion_ == StressMotion::kTapEdge ? Vec3(a + quarter * (b - a))
                                              : Vec3(a + u * (b - a) + v * (c - a));
  }

  void go_to(std::vector<Vec3>& places, const Vec3& to, double step) {
    const Vec3 from = places.back();
    const auto n = static_cast<std::size_t>(std::clamp(std::ceil((to - from).norm() / step), 1.0, 200.0));
    for (std::size_t i = 1; i <= n; ++i)
      places.push_back(i == n ? to : Vec3(from + (static_cast<double>(i) / static_cast<double>(n)) * (to - from)));
  }

  void slide(std::vector<Vec3>& places) {
    walk_.start(triangle_, uniform(-std::numbers::pi, std::numbers::pi));
    const double step = extent_ * power(-5.0, -1.5);
    const double depth = extent_ * power(-4.0, -1.5);
    const double bend = 0.3 * normal();
    go_to(places, walk_.point() - depth * side_ * walk_.normal(), extent_ * 0.01);
    Vec3 up = side_ * walk_.normal();
    for (int i = 0; i < 300; ++i) {
      walk_.turn(bend * normal());
      walk_.advance(step);
      up = (up + 0.2 * (side_ * walk_.normal() - up));
      places.push_back(walk_.point() - depth * (1.0 + 0.7 * std::sin(0.1 * i)) * up);
    }
  }

  void tap(std::vector<Vec3>& places) {
    const double step = extent_ * power(-3.5, -1.0);
    // Straight down the normal, or from any direction on the near side.
    Vec3 from = up_;
    if (random_() % 2 == 0) {
      from = direction();
      if (from.dot(up_) < 0.0) from = -from;
    }
    const Vec3 above = at_ + 0.02 * extent_ * from;
    go_to(places, above, 0.01 * extent_);
    const double depth = extent_ * power(-4.0, -1.5);
    for (int i = 0; i < 3; ++i) {
      go_to(places, at_, step);
      go_to(places, at_ - depth * from, step);
      for (int k = 0; k < 5; ++k) places.push_back(places.back());
      go_to(places, above, step);
    }
  }

  void coincide(std::vector<Vec3>& places) {
    const Vec3 &a = mesh_.corner(triangle_, 0), &b = mesh_.corner(triangle_, 1), &c = mesh_.corner(triangle_, 2);
    auto on_lattice = [&] {
      const auto u = static_cast<double>(static_cast<int>(random_() % 7) - 2) / 2.0;
      const auto v = static_cast<double>(static_cast<int>(random_() % 7) - 2) / 2.0;
      const double lift = random_() % 3 == 0 ? (random_() % 2 == 0 ? 1.0 : -1.0) * power(-16.0, -8.0) * extent_ : 0.0;
      return Vec3(a + u * (b - a) + v * (c - a) + lift * up_);
    };
    const double size = std::max((b - a).norm(), (c - a).norm());
    for (int i = 0; i < 12; ++i) go_to(places, on_lattice(), std::max(size * power(-2.0, 0.5), 1e-3 * extent_));
    go_to(places, at_ - extent_ * power(-6.0, -1.5) * up_, 0.003 * extent_);
    for (int i = 0; i < 6; ++i) go_to(places, on_lattice() - extent_ * power(-6.0, -2.0) * up_, std::max(0.3 * size, 2e-3 * extent_));
  }

  void graze(std::vector<Vec3>& places) {
    Vec3 along = direction();
    along = (along - along.dot(up_) * up_).normalized();
    const double reach = extent_ * power(-3.0, -0.3);
    const double tilt = power(-15.0, -1.0);
    const Vec3 from = at_ - reach * along + reach * tilt * up_;
    go_to(places, from, 0.02 * extent_);
    for (int i = 0; i < 4; ++i) {
      go_to(places, at_ + reach * along - reach * tilt * up_, reach * power(-1.5, 0.5));
      go_to(places, from, reach * power(-1.5, 0.5));
    }
  }

  void jump(std::vector<Vec3>& places) {
    const Vec3 middle = start_;
    for (int i = 0; i < 200; ++i) {
      places.push_back(random_() % 8 == 0 ? at_ - extent_ * power(-4.0, -0.5) * up_
                                          : Vec3(middle + extent_ * power(-2.0, 0.3) * direction()));
    }
  }

  void creep(std::vector<Vec3>& places) {
    const double step = extent_ * power(-12.0, -6.0);
    places.push_back(at_ + 2.0 * step * up_);
    Vec3 drift = direction();
    for (int i = 0; i < 150; ++i) {
      if (i % 50 == 0) drift = direction();
      places.push_back(places.back() + step * (0.5 * drift + 0.5 * direction() - 0.2 * up_));
    }
    const double deep = extent_ * power(-9.0, -2.0);
    places.push_back(at_ - deep * up_);
    for (int i = 0; i < 100; ++i) places.push_back(places.back() + step * direction());
  }

  void wander(std::vector<Vec3>& places) { walk_round(places, extent_ * power(-4.0, -2.0), uniform(0.02, 0.3), kWalkSteps); }

  // A long walk: from one place of the body to the next, at another pace each time.
  void travel(std::vector<Vec3>& places) {
    for (int leg = 0; leg < kLongWalkLegs; ++leg) {
      walk_round(places, extent_ * power(-4.0, -2.0), uniform(0.02, 0.3), kLongWalkLegSteps);
      choose_place();
    }
  }

  // Drawn gently to `at_`, which is on the surface.
  void walk_round(std::vector<Vec3>& places, double speed, double memory, int steps) {
    Vec3 velocity = Vec3::Zero();
    Vec3 at = places.back();
    for (int i = 0; i < steps; ++i) {
      velocity += -memory * velocity + speed * std::sqrt(2.0 * memory) * Vec3(normal(), normal(), normal()) - 0.02 * memory * (at - at_);
      at += velocity;
      places.push_back(motion_ == StressMotion::kHostile && random_() % 16 == 0 ? hostile(at) : at);
    }
  }

  Vec3 hostile(Vec3 at) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double bad[] = {std::numeric_limits<double>::quiet_NaN(),  kInfinity, -kInfinity, 1e308, -1e30, 1e9 * extent_,
                          std::numeric_limits<double>::denorm_min(), -0.0};
    at[static_cast<int>(random_() % 3)] = bad[random_() % 8];
    return at;
  }

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

// Where the segment meets the mesh, well inside a face. Every triangle is asked.
std::optional<Vec3> find_crossing(const TriangleMesh& mesh, const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3& a = mesh.corner(i, 0);
    const Vec3 ab = mesh.corner(i, 1) - a;
    const Vec3 ac = mesh.corner(i, 2) - a;
    const Vec3 n = ab.cross(ac);
    const double slope = -way.dot(n);
    const Vec3 ap = from - a;
    const double t = ap.dot(n) / slope;
    if (!(t > 1e-3 && t < 0.999)) continue;
    const Vec3 e = ap.cross(way);
    const double v = ac.dot(e) / slope;
    const double w = -ab.dot(e) / slope;
    if (v > 0.05 && w > 0.05 && v + w < 0.95) return Vec3(from + t * way);
  }
  return std::nullopt;
}

}  // namespace

std::string_view name_of(StressMotion motion) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressMotion::kCount)> kNames = {
      "slide", "tap-face", "tap-vertex", "tap-edge", "coincident", "near-parallel", "fast", "tiny", "walk", "hostile"};
  return kNames[static_cast<std::size_t>(motion)];
}

std::string_view name_of(StressFault fault) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressFault::kCount)> kNames = {"fall", "inside", "through",    "lock",
                                                                                                  "lag",  "pop",    "not-finite", "broken"};
  return kNames[static_cast<std::size_t>(fault)];
}

std::string_view meaning_of(StressFault fault) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressFault::kCount)> kMeanings = {
      "no force with the device more than 0.25 % of the extent inside; closed bodies",
      "the proxy itself inside; closed bodies",
      "straight through a face from one free place to another, where the reference does not come; open meshes, point probe",
      "proxy more than 10 % of the extent farther off than the surface, and not at rest; closed bodies, no friction",
      "proxy not at rest: the reference, started there, comes nearer by 0.1 % of the extent; no friction",
      "the force changed by more than stiffness times motion; convex rooms, no friction",
      "a force or proxy that is NaN or infinite",
      "force, proxy and contact contradict each other, or a sample that is not finite is felt"};
  return kMeanings[static_cast<std::size_t>(fault)];
}

std::uint64_t StressCount::total_faults() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t fault : faults) sum += fault;
  return sum;
}

void StressCount::add(const StressCount& other) {
  steps += other.steps;
  contact_steps += other.contact_steps;
  episodes += other.episodes;
  judged_rests += other.judged_rests;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    faults[i] += other.faults[i];
    looked_for[i] = looked_for[i] || other.looked_for[i];
  }
  findings.insert(findings.end(), other.findings.begin(), other.findings.end());
}

struct StressRun::Inside {
  Inside(const StressBody& body_, const StressSettings& settings_, const MethodSettings& method_settings)
      : settings(settings_),
        extent(compute_bounds(body_.touched).extent() * settings_.scale),
        place(settings_.offset_extents * extent * Vec3(1.0, -1.0, 1.0)),
        body(placed(body_, settings_.scale, place)),
        walk_mesh(body.solid.triangles.empty() ? body.touched : body.solid),
        walk(walk_mesh) {
    probe_radius = body.probe_share * extent;
    if (!body.solid.triangles.empty()) solid.emplace(body.solid);
    scene.objects.push_back({std::make_shared<TriangleMesh>(body.touched), settings.material});
    method_with_probe = method_settings;
    method_with_probe.probe_radius_m = probe_radius;
    find_borders();
  }

  void find_borders() {
    if (solid) return;
    const TriangleMesh& mesh = body.touched;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const Triangle& triangle : mesh.triangles) {
      for (int k = 0; k < 3; ++k) edges.push_back(std::minmax(triangle[k], triangle[(k + 1) % 3]));
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t first = 0; first < edges.size();) {
      std::size_t last = first;
      while (last < edges.size() && edges[last] == edges[first]) ++last;
      if (last - first == 1) borders.push_back(edges[first]);
      first = last;
    }
  }

  // From one free place to another straight through a face, with no border within ten such steps to slide round.
  bool goes_through(const Vec3& from, const Vec3& to) const {
    const double step = (to - from).norm();
    if (!(step > 0.0) || step > kThroughStep * extent) return false;
    const std::optional<Vec3> crossing = find_crossing(body.touched, from, to);
    if (!crossing) return false;
    return !is_near_border(*crossing, 10.0 * step);
  }

  bool is_near_border(const Vec3& p, double reach) const {
    return std::any_of(borders.begin(), borders.end(), [&](const auto& border) {
      const Vec3& a = body.touched.vertices[border.first];
      const Vec3& b = body.touched.vertices[border.second];
      return closest_point(a, b, b, p).distance < reach;
    });
  }

  // The reference, which asks every triangle, comes there too: round an edge or corner that the straight way cuts.
  bool leads_round(const Vec3& from, const Vec3& to) const { return (judge->settle_from(from, to).p_SP - to).norm() <= kRelative * extent; }

  // From a little farther off as well: begun within a hover of a corner, the reference may take the wrong side of a face for its own.
  bool gains_from_outside(const Vec3& p, const Vec3& device) const {
    const Vec3 stretch = p - device;
    const Vec3 start = p + (kOutsideShare * extent / stretch.norm()) * stretch;
    return stretch.norm() - (judge->settle_from(start, device).p_SP - device).norm() > kLagGain * extent;
  }

  // A point is held there for certain, however far the reference gets that climbs by its own lift.
  bool is_proved(const Vec3& p, const Vec3& device, double hover) const {
    return probe_radius == 0.0 && is_certain_rest(body.touched, p, device, kRestHovers * hover);
  }

  // On the side the device may not be on.
  bool is_wrong(const Vec3& p) const { return solid && solid->is_inside(p) != body.room; }

  bool is_free(const Vec3& p) const {
    if (!solid) return true;
    if (is_wrong(p)) return false;
    return probe_radius == 0.0 || solid->compute_distance(p) > 1.01 * probe_radius;
  }

  bool rubs() const { return settings.material.friction_static > 0.0; }
  // A room is convex: without friction and damping its proxy is a projection onto a convex set.
  bool shows_pops() const { return body.room && !rubs() && settings.material.damping_ns_per_m == 0.0; }

  bool looks_for(StressFault fault) const {
    switch (fault) {
      case StressFault::kFall:
      case StressFault::kInside:
        return solid.has_value();
      case StressFault::kThrough:
        return !solid && probe_radius == 0.0;
      case StressFault::kLock:
        return solid && !rubs();
      case StressFault::kLag:
        return !rubs();
      case StressFault::kPop:
        return shows_pops();
      default:
        return true;
    }
  }

  void mark_looked_for(StressCount& count) const {
    for (std::size_t i = 0; i < count.looked_for.size(); ++i) count.looked_for[i] |= looks_for(static_cast<StressFault>(i));
  }

  void note(StressCount& count, StressFault fault, StressMotion motion, std::uint64_t episode, std::size_t step, double size) const {
    ++count.faults[static_cast<std::size_t>(fault)];
    std::size_t same = 0;
    for (const StressFinding& finding : count.findings) same += finding.fault == fault && finding.motion == motion;
    if (same < kMostFindings) count.findings.push_back({fault, motion, episode, step, size});
  }

  StressSettings settings;
  double extent;
  Vec3 place;
  StressBody body;
  TriangleMesh walk_mesh;
  SurfaceWalk walk;
  double probe_radius = 0.0;
  std::optional<PointInMesh> solid;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> borders;
  TouchScene scene;
  MethodSettings method_with_probe;
  std::unique_ptr<ForceMethod> method;
  std::unique_ptr<ReferenceMethod> judge;
  std::vector<Vec3> places;
};

StressRun::StressRun(std::unique_ptr<Inside> inside) : inside_(std::move(inside)) {}
StressRun::~StressRun() = default;
StressRun::StressRun(StressRun&&) noexcept = default;
StressRun& StressRun::operator=(StressRun&&) noexcept = default;

Result<StressRun> StressRun::make(const StressBody& body, const StressSettings& settings, const MethodSettings& method,
                                  const MethodMaker& maker) {
  if (body.touched.triangles.empty()) return fail("stress: body '{}' has no triangles", body.name);
  auto inside = std::make_unique<Inside>(body, settings, method);
  auto made = maker(inside->method_with_probe, inside->scene);
  if (!made) return tl::unexpected(made.error());
  inside->method = std::move(*made);
  auto judge = ReferenceMethod::make_reference(inside->method_with_probe, inside->scene);
  if (!judge) return tl::unexpected(judge.error());
  inside->judge = std::move(*judge);
  return StressRun(std::move(inside));
}

std::size_t StressRun::run_episode(std::uint64_t number, StressCount& count) {
  Inside& in = *inside_;
  const double extent = in.extent;
  const double stiffness = in.settings.material.stiffness_n_per_m;
  Episode episode(in.walk_mesh, in.walk, extent, !in.body.room, in.settings.seed, in.body.name, number);
  episode.draw([&](const Vec3& p) { return in.is_free(p); }, in.places);
  // No free place was found: nothing can be said about the sides, so nothing is judged.
  ++count.episodes;
  if (!in.is_free(in.places.front())) return 0;
  in.mark_looked_for(count);
  in.method->reset(in.places.front());
  Vec3 before = in.places.front();
  MethodOutput felt_before;
  felt_before.p_SP = before;
  for (std::size_t i = 0; i < in.places.size(); ++i) {
    const Vec3& device = in.places[i];
    const MethodOutput felt = in.method->step({.p_SD = device});
    ++count.steps;
    count.contact_steps += felt.contact;
    auto note = [&](StressFault fault, double size) { in.note(count, fault, episode.motion(), number, i, size / extent); };
    if (!felt.force_n.allFinite() || !felt.p_SP.allFinite()) {
      note(StressFault::kNotFinite, 0.0);
      continue;
    }
    if (!device.allFinite()) {
      if (felt.contact || !felt.force_n.isZero(0.0)) note(StressFault::kBroken, 0.0);
      continue;
    }
    const double far = (device - in.place).cwiseAbs().maxCoeff();
    if (far > 1e3 * extent) {  // a proxy so far behind has no digits left to be judged by
      before = device;
      felt_before = felt;
      continue;
    }
    const Vec3 stretch = felt.p_SP - device;
    const double length = stretch.norm();
    const double play = extent * (kRelative + 1e-15 * in.settings.offset_extents);
    const bool undamped = in.settings.material.damping_ns_per_m == 0.0;
    if (felt.contact != (felt.force_n.norm() > 0.0)) note(StressFault::kBroken, 0.0);
    if (undamped && (felt.force_n - stiffness * stretch).norm() > stiffness * (play + kRelative * length))
      note(StressFault::kBroken, (felt.force_n / stiffness - stretch).norm());
    if (!felt.contact && length > play) note(StressFault::kBroken, length);
    if (in.solid) {
      if (!felt.contact && in.is_wrong(device)) {
        const double depth = in.solid->compute_distance(device);
        if (depth > kFallShare * extent) note(StressFault::kFall, depth);
      }
      const Vec3 outward = length > 0.0 ? Vec3(felt.force_n.normalized()) : Vec3(Vec3::Zero());
      if (felt.contact && in.is_wrong(felt.p_SP + kInsideShare * extent * outward) && in.is_wrong(felt.p_SP)) {
        const double depth = in.solid->compute_distance(felt.p_SP);
        if (depth > 2.0 * kInsideShare * extent) note(StressFault::kInside, depth);
      }
    } else if (!felt.contact && !felt_before.contact && in.probe_radius == 0.0 && in.goes_through(felt_before.p_SP, felt.p_SP) &&
               !in.leads_round(felt_before.p_SP, felt.p_SP)) {
      note(StressFault::kThrough, (device - before).norm());
    }
    // Friction holds the proxy short of the minimum; the question has no meaning there.
    const bool suspicious = length > kLockShare * extent;
    if (felt.contact && !in.rubs() && (suspicious || (in.settings.rest_every > 0 && (i + number) % in.settings.rest_every == 0))) {
      ++count.judged_rests;
      const MethodOutput rested = in.judge->settle_from(felt.p_SP, device);
      const double gain = length - (rested.p_SP - device).norm();
      // A device on the surface itself has two rightful proxies: at the ridge it came in by, and where it is.
      const double depth = gain > kLagGain * extent && in.solid ? in.solid->compute_distance(device) : extent;
      const bool is_late = gain > kLagGain * extent && depth > kTieShare * extent;
      if (is_late && !in.is_near_border(felt.p_SP, kMouthShare * extent) && in.gains_from_outside(felt.p_SP, device) &&
          !in.is_proved(felt.p_SP, device, play)) {
        note(in.solid && gain > kLockGain * extent && length > depth + kLockShare * extent ? StressFault::kLock : StressFault::kLag, gain);
      }
    }
    if (in.shows_pops() && i > 0 && before.allFinite()) {
      const double jump = (felt.force_n - felt_before.force_n).norm() / stiffness;
      const double above = jump - (device - before).norm() * (1.0 + 1e-6) - 10.0 * play;
      if (above > 0.0) note(StressFault::kPop, above);
    }
    before = device;
    felt_before = felt;
  }
  return in.places.size();
}

}  // namespace hapton
