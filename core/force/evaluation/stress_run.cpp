#include "core/force/evaluation/stress_run.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/force/evaluation/certain_rest.h"
#include "core/force/evaluation/close_up_rest.h"
#include "core/force/reference/reference_method.h"
#include "core/force/smooth/smooth_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/point_in_mesh.h"
#include "core/geometry/surface_walk.h"
#include "core/geometry/winding_number.h"

namespace hapton {
namespace {

constexpr double kFallShare = 0.0025;
constexpr double kInsideShare = 1e-6;  // above what the contact offset of a probe is and what a million extents of offset round to
constexpr double kLockShare = 0.10;
constexpr double kLockGain = 0.01;
constexpr double kLagGain = 0.001;
constexpr double kTieShare = 1e-6;
constexpr double kOutsideShare = 1e-7;
constexpr double kBesideShare = 1e-6;  // farther than the reference lifts itself over a step
constexpr double kClearShare = 0.05;   // of the contact offset that a proxy may keep: above rounding, so the side is beyond doubt
constexpr double kCloseUpShare = 0x1p-10;
constexpr double kMouthShare =
    1e-5;  // at the mouth of a crack: where it is narrower than one of the two contact offsets, only the other gets in
constexpr double kRestOffsets = 4.0;  // round a rest that may be proved to be one
constexpr double kThroughStep = 0.01;
constexpr double kRelative = 4e-9;        // a method may keep this share of the extent as contact offset and leave that out of the force
constexpr std::size_t kMostFindings = 1;  // of each fault in each motion

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

Vec3 corner_direction(int corner) { return {corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0}; }

}  // namespace

std::string_view name_of(StressFault fault) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressFault::count)> kNames = {"fall", "inside", "through",    "lock",
                                                                                                 "lag",  "pop",    "not-finite", "broken"};
  return kNames[static_cast<std::size_t>(fault)];
}

std::string_view meaning_of(StressFault fault) {
  constexpr std::array<std::string_view, static_cast<std::size_t>(StressFault::count)> kMeanings = {
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

  bool is_on_surface(const Vec3& p, double within) const {
    const TriangleMesh& mesh = body.touched;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (closest_point(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2), p).distance <= within) return true;
    }
    return false;
  }

  // The reference, which asks every triangle, comes there too: round an edge or corner that the straight way cuts.
  bool leads_round(const Vec3& from, const Vec3& to) const { return (judge->settle_from(from, to).p_SP - to).norm() <= kRelative * extent; }

  // A proxy may keep so much contact offset and leave that out of the force.
  double play() const { return extent * (kRelative + 1e-15 * settings.offset_extents); }

  // Told exactly, however near the surface.
  bool is_beyond(const Vec3& p) const { return (std::fabs(compute_winding_number(body.solid, p)) > 0.5) != body.room; }

  // Where the reference begins: p, or beside it on the free side, if p lies on the closed surface itself to the last digits. There the
  // reference would take either side for its own.
  Vec3 clear_start(const Vec3& p) const {
    const auto is_clear = [&](const Vec3& at) { return solid->compute_distance(at) > kClearShare * play() && !is_beyond(at); };
    if (!solid || probe_radius > 0.0 || is_clear(p)) return p;
    for (const double step : {0.25, 1.0}) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 start = p + step * play() * corner_direction(corner);
        if (is_clear(start)) return start;
      }
    }
    return p;
  }

  // From a little farther off as well: begun within a contact offset of a corner, the reference may take the wrong side of a face for its
  // own.
  bool gains_from_outside(const Vec3& p, const Vec3& device) const {
    const Vec3 stretch = p - device;
    const Vec3 start = clear_start(p + (kOutsideShare * extent / stretch.norm()) * stretch);
    return stretch.norm() - (judge->settle_from(start, device).p_SP - device).norm() > kLagGain * extent;
  }

  // Wherever just beside it the device is. Where its way grazes a face, rounding says on which side of that it goes.
  bool gains_from_beside(const Vec3& p, const Vec3& device) const {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 beside = device + kBesideShare * extent * corner_direction(corner);
      if ((p - beside).norm() - (judge->settle_from(clear_start(p), beside).p_SP - beside).norm() <= kLagGain * extent) return false;
    }
    return true;
  }

  // A point is held there for certain, however far the reference gets that climbs by its own lift.
  bool is_proved(const Vec3& p, const Vec3& device, double contact_offset) const {
    return probe_radius == 0.0 && is_certain_rest(body.touched, p, device, kRestOffsets * contact_offset);
  }

  // What holds the proxy may be lower than the reference lifts itself in the whole body: a point a thousand times smaller tells.
  bool is_held_closely(const Vec3& p, const Vec3& device) const {
    return probe_radius == 0.0 && rests_in_close_up(body.touched, settings.material, p, kCloseUpShare * extent, clear_start(p), device);
  }

  // Asks the reference whether the proxy may stay at p.
  template <class Note>
  void judge_rest(const Vec3& p, const Vec3& device, const Note& note) const {
    const double length = (p - device).norm();
    if (!(length - (judge->settle_from(p, device).p_SP - device).norm() > kLagGain * extent)) return;
    const Vec3 end = judge->settle_from(clear_start(p), device).p_SP;
    const double gain = length - (end - device).norm();
    if (!(gain > kLagGain * extent)) return;
    // A judge that ends on the other side of a closed surface went through it, and proves nothing.
    if (is_wrong(end) && solid->compute_distance(end) > 2.0 * kInsideShare * extent && !is_wrong(p)) return;
    // A device on the surface itself has two rightful proxies: at the ridge it came in by, and where it is.
    const double depth = solid ? solid->compute_distance(device) : extent;
    if (depth <= kTieShare * extent || is_near_border(p, kMouthShare * extent) || !gains_from_outside(p, device) ||
        !gains_from_beside(p, device) || is_held_closely(p, device))
      return;
    note(solid && gain > kLockGain * extent && length > depth + kLockShare * extent ? StressFault::lock : StressFault::lag, gain);
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
  bool shows_pops() const { return body.room && !rubs() && settings.material.damping_ns_per_m == 0.0 && layer == 0.0; }

  bool looks_for(StressFault fault) const {
    switch (fault) {
      case StressFault::fall:
      case StressFault::inside:
        return solid.has_value();
      case StressFault::through:
        return !solid && probe_radius == 0.0;
      case StressFault::lock:
        return solid && !rubs();
      case StressFault::lag:
        return !rubs();
      case StressFault::pop:
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
  double layer = 0.0;  // smooth: how far outside the surface its force begins; it may add that much to the spring
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
  if (const auto* smooth = dynamic_cast<const SmoothMethod*>(inside->method.get())) inside->layer = smooth->layer_m();
  auto judge = ReferenceMethod::make_reference(inside->method_with_probe, inside->scene);
  if (!judge) return tl::unexpected(judge.error());
  inside->judge = std::move(*judge);
  return StressRun(std::move(inside));
}

std::size_t StressRun::run_episode(std::uint64_t number, StressCount& count) {
  Inside& in = *inside_;
  const double extent = in.extent;
  const double stiffness = in.settings.material.stiffness_n_per_m;
  StressEpisode episode(in.walk_mesh, in.walk, extent, !in.body.room, in.settings.seed, in.body.name, number);
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
    const auto note = [&](StressFault fault, double size) { in.note(count, fault, episode.motion(), number, i, size / extent); };
    if (!felt.force_n.allFinite() || !felt.p_SP.allFinite()) {
      note(StressFault::not_finite, 0.0);
      continue;
    }
    if (!device.allFinite()) {
      if (felt.contact || !felt.force_n.isZero(0.0)) note(StressFault::broken, 0.0);
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
    const double play = in.play();
    const bool undamped = in.settings.material.damping_ns_per_m == 0.0;
    if (felt.contact != (felt.force_n.norm() > 0.0)) note(StressFault::broken, 0.0);
    if (undamped && (felt.force_n - stiffness * stretch).norm() > stiffness * (play + kRelative * length + in.layer))
      note(StressFault::broken, (felt.force_n / stiffness - stretch).norm());
    if (!felt.contact && length > play) note(StressFault::broken, length);
    if (in.solid) {
      if (!felt.contact && in.is_wrong(device)) {
        const double depth = in.solid->compute_distance(device);
        if (depth > kFallShare * extent) note(StressFault::fall, depth);
      }
      const Vec3 outward = length > 0.0 ? Vec3(felt.force_n.normalized()) : Vec3(Vec3::Zero());
      if (felt.contact && in.is_wrong(felt.p_SP + kInsideShare * extent * outward) && in.is_wrong(felt.p_SP)) {
        const double depth = in.solid->compute_distance(felt.p_SP);
        if (depth > 2.0 * kInsideShare * extent) note(StressFault::inside, depth);
      }
    } else if (!felt.contact && !felt_before.contact && in.probe_radius == 0.0 && in.goes_through(felt_before.p_SP, felt.p_SP) &&
               !in.leads_round(felt_before.p_SP, felt.p_SP)) {
      // On the surface to the last digit a place has no side: only ways between places off it are judged.
      if (in.is_on_surface(felt.p_SP, play) || in.is_on_surface(felt_before.p_SP, play)) continue;
      note(StressFault::through, (device - before).norm());
    }
    // Friction holds the proxy short of the minimum; the question has no meaning there.
    const bool suspicious = length > kLockShare * extent;
    if (felt.contact && !in.rubs() && (suspicious || (in.settings.rest_every > 0 && (i + number) % in.settings.rest_every == 0))) {
      ++count.judged_rests;
      if (!in.is_proved(felt.p_SP, device, play)) in.judge_rest(felt.p_SP, device, note);
    }
    if (in.shows_pops() && i > 0 && before.allFinite()) {
      const double jump = (felt.force_n - felt_before.force_n).norm() / stiffness;
      const double above = jump - (device - before).norm() * (1.0 + 1e-6) - 10.0 * play;
      if (above > 0.0) note(StressFault::pop, above);
    }
    before = device;
    felt_before = felt;
  }
  return in.places.size();
}

}  // namespace hapton
