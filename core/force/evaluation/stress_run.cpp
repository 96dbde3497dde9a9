#include "core/force/evaluation/stress_run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "core/force/evaluation/certain_minimum.h"
#include "core/force/evaluation/close_up_minimum.h"
#include "core/force/reference/reference_method.h"
#include "core/force/reference/triangle_boxes.h"
#include "core/force/smooth/smooth_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/point_in_mesh.h"
#include "core/geometry/shared_edges.h"
#include "core/geometry/surface_walk.h"
#include "core/geometry/winding_number.h"

namespace hapton {
namespace {

// Shares are of the extent. Those of a fault define the fault (meaning_of): free choices that only have to stay the same.
constexpr double kFallThroughShare = 0.0025;
constexpr double kUnsureShare = 2e-7;  // nearer to the surface than this, PointInMesh may name either side
constexpr double kInsideShare = 1e-6;  // larger than a probe's contact offset and the rounding of an offset of a million extents
constexpr double kStuckShare = 0.10;
constexpr double kStuckGain = 0.01;
constexpr double kUnconvergedGain = 0.001;
constexpr double kTieShare = 1e-6;      // a device nearer to the surface than this has two valid proxies
constexpr double kOutsideShare = 1e-7;  // farther off than a contact offset (kContactOffsetShare)
constexpr double kBesideShare = 1e-6;   // more than the height of a ledge that the reference climbs over
constexpr double kClearShare = 0.05;    // share of the contact offset that a proxy may keep: above rounding, so the side is certain
constexpr double kCloseUpShares[] = {0x1p-10, 0x1p-18};
constexpr double kCrackShare =
    1e-5;  // at a crack that is narrower than the contact offset of the method or the reference, only the other proxy gets in
constexpr double kProofOffsets = 4.0;         // radius, in contact offsets, of the proof that a position is a minimum
constexpr double kThroughStep = 0.01;         // a longer step may have led round a boundary edge
constexpr double kContactOffsetShare = 4e-9;  // a method may use this share of the extent as contact offset and leave it out of the force
constexpr int kMaxCarried = 1024;             // largest number of steps of a carried motion
constexpr std::size_t kMaxFindings = 1;       // findings kept of each fault in each motion

struct Crossing {
  Vec3 place = Vec3::Zero();
  double height = 0.0;  // of the segment's end that is nearer to the plane of the face, above that plane
};

// Where the segment crosses a face, well away from the edges of the face. Tests every triangle that the segment may meet; of several
// crossings the one with the largest height counts.
std::optional<Crossing> find_crossing(const TriangleMesh& mesh, TriangleBoxes& boxes, const Vec3& from, const Vec3& to) {
  const Vec3 motion = to - from;
  std::optional<Crossing> clearest;
  for (const std::uint32_t i : boxes.find_near(0.5 * (from + to), 0.5 * motion.norm())) {
    const Vec3& a = mesh.corner(i, 0);
    const Vec3& b = mesh.corner(i, 1);
    const Vec3& c = mesh.corner(i, 2);
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 n = ab.cross(ac);
    const double slope = -motion.dot(n);
    const Vec3 ap = from - a;
    const double t = ap.dot(n) / slope;
    if (!(t > 1e-3 && t < 0.999)) continue;
    const Vec3 e = ap.cross(motion);
    const double v = ac.dot(e) / slope;
    const double w = -ab.dot(e) / slope;
    if (!(v > 0.05 && w > 0.05 && v + w < 0.95)) continue;
    const double height = std::min(t, 1.0 - t) * std::fabs(slope) / n.norm();
    if (!clearest || height > clearest->height) clearest = {from + t * motion, height};
  }
  return clearest;
}

struct FaultText {
  std::string_view name, meaning;
};

constexpr std::array<FaultText, static_cast<std::size_t>(StressFault::count)> kFaults = {{
    {"fall_through", "no force with the device more than 0.25 % of the extent inside; closed bodies"},
    {"inside", "the proxy is inside; closed bodies"},
    {"through",
     "the proxy went straight through a face from one free position to another, which the reference does not reach; open meshes, point "
     "probe"},
    {"stuck",
     "proxy more than 10 % of the extent farther from the device than the surface, and not at a minimum; closed bodies, no friction"},
    {"unconverged", "proxy not at a minimum: the reference, started there, comes nearer by 0.1 % of the extent; no friction"},
    {"discontinuity", "the force changed by more than stiffness times motion; convex rooms, no friction"},
    {"not_finite", "a force or proxy that is NaN or infinite"},
    {"broken", "force, proxy and contact contradict each other, or a sample that is not finite gives a force"},
}};

Vec3 corner_direction(int corner) { return {corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0}; }

}  // namespace

std::string_view name_of(StressFault fault) { return kFaults[static_cast<std::size_t>(fault)].name; }

std::string_view meaning_of(StressFault fault) { return kFaults[static_cast<std::size_t>(fault)].meaning; }

std::uint64_t StressCount::total_faults() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t fault : faults) sum += fault;
  return sum;
}

void StressCount::add(const StressCount& other) {
  steps += other.steps;
  contact_steps += other.contact_steps;
  episodes += other.episodes;
  compared_steps += other.compared_steps;
  carried_steps += other.carried_steps;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    faults[i] += other.faults[i];
    covered[i] = covered[i] || other.covered[i];
  }
  findings.insert(findings.end(), other.findings.begin(), other.findings.end());
}

struct StressRun::Impl {
  Impl(const StressBody& body_, const StressSettings& settings_, const MethodSettings& method_settings)
      : settings(settings_),
        extent(compute_bounds(body_.touched).extent() * settings_.scale),
        offset(settings_.offset_extents * extent * Vec3(1.0, -1.0, 1.0)),
        body(placed(body_, settings_.scale, offset)),
        boxes(body.touched.vertices, body.touched.triangles),
        walk_mesh(body.solid.triangles.empty() ? body.touched : body.solid),
        walk(walk_mesh) {
    probe_radius = body.probe_share * extent;
    if (!body.solid.triangles.empty()) solid.emplace(body.solid);
    scene.objects.push_back({std::make_shared<TriangleMesh>(body.touched), settings.material});
    method_with_probe = method_settings;
    method_with_probe.probe_radius_m = probe_radius;
    find_boundary_edges();
  }

  void find_boundary_edges() {
    if (solid) return;
    const SharedEdges edges(body.touched.triangles);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if (edges[e].size() == 1) boundary_edges.emplace_back(edges[e][0].low, edges[e][0].high);
    }
  }

  // Where the straight path between two free positions crosses a face, if no boundary it could lead round is within ten times its length.
  std::optional<Crossing> find_passage(const Vec3& from, const Vec3& to) const {
    const double step = (to - from).norm();
    if (!(step > 0.0) || step > kThroughStep * extent) return std::nullopt;
    const std::optional<Crossing> crossing = find_crossing(body.touched, boxes, from, to);
    return crossing && !is_near_boundary(crossing->place, 10.0 * step) ? crossing : std::nullopt;
  }

  bool is_near_boundary(const Vec3& p, double radius) const {
    return std::any_of(boundary_edges.begin(), boundary_edges.end(), [&](const auto& edge) {
      const Vec3& a = body.touched.vertices[edge.first];
      const Vec3& b = body.touched.vertices[edge.second];
      return closest_point(a, b, b, p).distance < radius;
    });
  }

  bool is_on_surface(const Vec3& p, double within) const {
    const TriangleMesh& mesh = body.touched;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      if (closest_point(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2), p).distance <= within) return true;
    }
    return false;
  }

  // Whether the reference, which tests every triangle, also reaches `to`: round an edge or a vertex past which the straight path cuts.
  bool leads_round(const Vec3& from, const Vec3& to) const {
    if ((reference->settle_from(from, to).p_SP - to).norm() <= kContactOffsetShare * extent) return true;
    // A device that moves to its end may take the proxy round a corner. The corner holds the proxy if the device is at the end at once.
    reference->reset(from);
    reference->step({.p_SD = from});
    return (reference->step({.p_SD = to}).p_SP - to).norm() <= kContactOffsetShare * extent;
  }

  // A proxy may keep this contact offset and leave it out of the force.
  double slop() const { return extent * (kContactOffsetShare + 1e-15 * settings.offset_extents); }

  // Whether p is on the side where the proxy must not be. Exact, however near p is to the surface.
  bool is_beyond(const Vec3& p) const { return (std::fabs(compute_winding_number(body.solid, p)) > 0.5) != body.room; }

  // Where the reference starts: p, or a free point beside it if p lies on the closed surface up to rounding, where the reference could take
  // either side.
  Vec3 clear_start(const Vec3& p) const {
    const auto is_clear = [&](const Vec3& at) { return solid->compute_distance(at) > kClearShare * slop() && !is_beyond(at); };
    if (!solid || probe_radius > 0.0 || is_clear(p)) return p;
    for (const double step : {0.25, 1.0}) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 start = p + step * slop() * corner_direction(corner);
        if (is_clear(start)) return start;
      }
    }
    return p;
  }

  // Whether the reference gains more than kUnconvergedGain on p. It stops as soon as it has: the rest of a long path takes seconds.
  bool gains(const Vec3& start, const Vec3& p, const Vec3& device) const {
    const double length = (p - device).norm();
    const double near_enough = (length - kUnconvergedGain * extent) * (1.0 - 0x1p-30);
    return length - (reference->settle_from(start, device, near_enough).p_SP - device).norm() > kUnconvergedGain * extent;
  }

  // A start a little farther off: from within a contact offset of an edge or vertex, the reference may take the wrong side of a face.
  Vec3 outside_start(const Vec3& p, const Vec3& device) const {
    return clear_start(p + kOutsideShare * extent * (p - device).normalized());
  }

  // Whether the reference also gains for device positions all around this one: where its path grazes a face or an edge, rounding decides on
  // which side it passes. And for one back on the device's path: there, a minimum that vanishes just here still held the proxy.
  bool gains_from_beside(const Vec3& p, const Vec3& device, const Vec3& before) const {
    for (int corner = 0; corner < 8; ++corner) {
      if (!gains_with_moved(kBesideShare * extent * corner_direction(corner), p, device)) return false;
    }
    const Vec3 back = before - device;
    const double length = back.norm();
    return !(length > 0.0) || gains_with_moved(std::min(length, kBesideShare * extent) / length * back, p, device);
  }

  // Whether the reference gains from the same start, and from one that is moved along with the device, if no surface is in between.
  bool gains_with_moved(const Vec3& move, const Vec3& p, const Vec3& device) const {
    const Vec3 start = outside_start(p, device);
    if (!gains(clear_start(p), p, device + move)) return false;
    if (find_crossing(body.touched, boxes, start, start + move) || (solid && is_beyond(start + move))) return true;
    return gains(start + move, p + move, device + move);
  }

  // Whether p is proved to be a minimum, even if the reference climbs over the ledge of the surface that holds p.
  bool is_proved(const Vec3& p, const Vec3& device, double contact_offset) const {
    return probe_radius == 0.0 && is_certain_minimum(body.touched, boxes, p, device, kProofOffsets * contact_offset);
  }

  // The ledge that holds the proxy may be lower than those that the reference climbs over in the whole body. These tests use parts of the
  // body that are a thousand and a quarter of a million times smaller. start: clear_start(p).
  bool is_minimum_close_up(const Vec3& p, const Vec3& start, const Vec3& device) const {
    return probe_radius == 0.0 && std::any_of(std::begin(kCloseUpShares), std::end(kCloseUpShares), [&](double share) {
             return is_minimum_in_close_up(body.touched, boxes, settings.material, p, share * extent, start, device);
           });
  }

  // Checks with the reference whether p is a local minimum for the device, which was at `before` one sample ago.
  void check_minimum(const Vec3& p, const Vec3& device, const Vec3& before, const auto& note) const {
    const double length = (p - device).norm();
    const Vec3 start = clear_start(p);
    if (is_minimum_close_up(p, start, device)) return;  // first, as its few triangles cost the least
    if (!(length - (reference->settle_from(p, device).p_SP - device).norm() > kUnconvergedGain * extent)) return;
    const Vec3 end = reference->settle_from(start, device).p_SP;
    const double gain = length - (end - device).norm();
    if (!(gain > kUnconvergedGain * extent)) return;
    // A reference that ends on the other side of a closed surface has passed through it and proves nothing.
    if (is_wrong(end) && solid->compute_distance(end) > 2.0 * kInsideShare * extent && !is_wrong(p)) return;
    // A device on the surface itself has two valid proxies: one at the convex edge where the device came in, and one at the device.
    const double depth = solid ? solid->compute_distance(device) : extent;
    if (depth <= kTieShare * extent || is_near_boundary(p, kCrackShare * extent) || !gains(outside_start(p, device), p, device) ||
        !gains_from_beside(p, device, before))
      return;
    note(solid && gain > kStuckGain * extent && length > depth + kStuckShare * extent ? StressFault::stuck : StressFault::unconverged,
         gain);
  }

  // Force, contact and proxy have to agree.
  void check_consistency(const MethodOutput& output, const Vec3& device, const auto& note) const {
    const double stiffness = settings.material.stiffness_n_per_m;
    const Vec3 extension = output.p_SP - device;
    const double length = extension.norm();
    const bool undamped = settings.material.damping_ns_per_m == 0.0;
    const bool has_force = output.force_n.norm() > 0.0;
    const bool may_damping_take_it = !undamped && length > 0.0;
    if (output.contact != has_force && !(output.contact && may_damping_take_it)) note(StressFault::broken, 0.0);
    if (undamped && (output.force_n - stiffness * extension).norm() > stiffness * (slop() + kContactOffsetShare * length + layer))
      note(StressFault::broken, (output.force_n / stiffness - extension).norm());
    if (!output.contact && length > slop()) note(StressFault::broken, length);
  }

  // Neither a device without a force nor a proxy may be inside. first: the output before a carried motion was finished. Pre: solid.
  void check_sides(const MethodOutput& first, const MethodOutput& output, const Vec3& device, const auto& note) const {
    if (!(first.contact && output.contact) && is_wrong(device)) {
      const double depth = solid->compute_distance(device);
      if (depth > kFallThroughShare * extent) note(StressFault::fall_through, depth);
    }
    const bool is_pulled = (output.p_SP - device).norm() > 0.0;
    const Vec3 outward = is_pulled ? Vec3(output.force_n.normalized()) : Vec3(Vec3::Zero());
    if (output.contact && is_wrong(output.p_SP + kInsideShare * extent * outward) && is_wrong(output.p_SP)) {
      const double depth = solid->compute_distance(output.p_SP);
      if (depth > 2.0 * kInsideShare * extent) note(StressFault::inside, depth);
    }
  }

  // If the touched body is not a solid: checks that a probe that is free before and after a step has not gone through a surface. False: one
  // of the positions has no side: it is on the surface up to rounding, or beside the face that the path crosses and in its plane.
  bool check_through(const MethodOutput& output_before, const MethodOutput& output, double moved, const auto& note) const {
    if (output.contact || output_before.contact || probe_radius > 0.0) return true;
    const std::optional<Crossing> passage = find_passage(output_before.p_SP, output.p_SP);
    if (!passage || leads_round(output_before.p_SP, output.p_SP)) return true;
    if (passage->height <= slop() || is_on_surface(output.p_SP, slop()) || is_on_surface(output_before.p_SP, slop())) return false;
    note(StressFault::through, moved);
    return true;
  }

  // The force changes by no more than stiffness times the device's motion. Pre: shows_discontinuities().
  void check_discontinuity(const MethodOutput& output_before, const MethodOutput& output, double moved, const auto& note) const {
    const double jump = (output.force_n - output_before.force_n).norm() / settings.material.stiffness_n_per_m;
    const double above = jump - moved * (1.0 + 1e-6) - 10.0 * slop();
    if (above > 0.0) note(StressFault::discontinuity, above);
  }

  // Whether the local minimum is checked in this step. With friction the proxy is not at the minimum.
  bool is_comparison_due(const MethodOutput& output, const Vec3& device, std::uint64_t step) const {
    if (!output.contact || has_friction()) return false;
    return (output.p_SP - device).norm() > kStuckShare * extent || (settings.compare_every > 0 && step % settings.compare_every == 0);
  }

  // A method that is out of work carries the rest of a motion into the next step. Repeats the sample until the motion can be judged.
  MethodOutput finish(const MethodOutput& first, const Vec3& device, StressCount& count) {
    MethodOutput output = first;
    count.carried_steps += method->carried_from().has_value();
    for (int i = 0; method->carried_from() && i < kMaxCarried; ++i) output = method->step({.p_SD = device});
    return output;
  }

  // Whether p is on the wrong side of a closed surface: there, the device needs a force and the proxy must not be.
  bool is_wrong(const Vec3& p) const { return solid && solid->is_inside(p) != body.room; }

  bool is_free(const Vec3& p) const {
    if (!solid) return true;
    if (is_wrong(p) || solid->compute_distance(p) <= kUnsureShare * extent) return false;
    return probe_radius == 0.0 || solid->compute_distance(p) > 1.01 * probe_radius;
  }

  bool has_friction() const { return settings.material.friction_static > 0.0; }
  // A room is convex: without friction and damping its proxy is a projection onto a convex set.
  bool shows_discontinuities() const { return body.room && !has_friction() && settings.material.damping_ns_per_m == 0.0 && layer == 0.0; }

  bool covers(StressFault fault) const {
    switch (fault) {
      case StressFault::fall_through:
      case StressFault::inside:
        return solid.has_value();
      case StressFault::through:
        return !solid && probe_radius == 0.0;
      case StressFault::stuck:
        return solid && !has_friction();
      case StressFault::unconverged:
        return !has_friction();
      case StressFault::discontinuity:
        return shows_discontinuities();
      default:
        return true;
    }
  }

  void mark_covered(StressCount& count) const {
    for (std::size_t i = 0; i < count.covered.size(); ++i) count.covered[i] |= covers(static_cast<StressFault>(i));
  }

  void note(StressCount& count, StressFault fault, StressMotion motion, std::uint64_t episode, std::size_t step, double size) const {
    ++count.faults[static_cast<std::size_t>(fault)];
    std::size_t same = 0;
    for (const StressFinding& finding : count.findings) same += finding.fault == fault && finding.motion == motion;
    if (same < kMaxFindings) count.findings.push_back({fault, motion, episode, step, size});
  }

  StressSettings settings;
  double extent;
  Vec3 offset;
  StressBody body;
  mutable TriangleBoxes boxes;  // of the triangles of body.touched
  TriangleMesh walk_mesh;
  SurfaceWalk walk;
  double probe_radius = 0.0;
  double layer = 0.0;  // smooth: distance from the surface at which its force begins; its spring may be longer by that much
  std::optional<PointInMesh> solid;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> boundary_edges;
  TouchScene scene;
  MethodSettings method_with_probe;
  std::unique_ptr<ForceMethod> method;
  std::unique_ptr<ReferenceMethod> reference;
  std::vector<Vec3> positions;
};

StressRun::StressRun(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StressRun::~StressRun() = default;
StressRun::StressRun(StressRun&&) noexcept = default;
StressRun& StressRun::operator=(StressRun&&) noexcept = default;

Result<StressRun> StressRun::make(const StressBody& body, const StressSettings& settings, const MethodSettings& method,
                                  const MethodMaker& maker) {
  if (body.touched.triangles.empty()) return fail("stress: body '{}' has no triangles", body.name);
  auto impl = std::make_unique<Impl>(body, settings, method);
  auto made = maker(impl->method_with_probe, impl->scene);
  if (!made) return tl::unexpected(made.error());
  impl->method = std::move(*made);
  if (const auto* smooth = dynamic_cast<const SmoothMethod*>(impl->method.get())) impl->layer = smooth->layer_m();
  auto reference = ReferenceMethod::make_reference(impl->method_with_probe, impl->scene);
  if (!reference) return tl::unexpected(reference.error());
  impl->reference = std::move(*reference);
  return StressRun(std::move(impl));
}

std::size_t StressRun::run_episode(std::uint64_t number, StressCount& count) {
  Impl& impl = *impl_;
  const double extent = impl.extent;
  StressEpisode episode(impl.walk_mesh, impl.walk, extent, !impl.body.room, impl.settings.seed, impl.body.name, number);
  episode.draw([&](const Vec3& p) { return impl.is_free(p); }, impl.positions);
  // If no free position was found, the sides are unknown and the episode is skipped.
  ++count.episodes;
  if (!impl.is_free(impl.positions.front())) return 0;
  impl.mark_covered(count);
  impl.method->reset(impl.positions.front());
  Vec3 before = impl.positions.front();
  MethodOutput output_before;
  output_before.p_SP = before;
  for (std::size_t i = 0; i < impl.positions.size(); ++i) {
    const Vec3& device = impl.positions[i];
    const MethodOutput first = impl.method->step({.p_SD = device});
    const MethodOutput output = impl.finish(first, device, count);
    ++count.steps;
    count.contact_steps += output.contact;
    const auto note = [&](StressFault fault, double size) { impl.note(count, fault, episode.motion(), number, i, size / extent); };
    if (!output.force_n.allFinite() || !output.p_SP.allFinite() || !first.force_n.allFinite()) {
      note(StressFault::not_finite, 0.0);
      continue;
    }
    if (!device.allFinite()) {
      if (output.contact || !output.force_n.isZero(0.0)) note(StressFault::broken, 0.0);
      continue;
    }
    const double distance = (device - impl.offset).cwiseAbs().maxCoeff();
    if (distance > 1e3 * extent) {  // at this distance positions have too few digits to compare
      before = device;
      output_before = output;
      continue;
    }
    const double moved = (device - before).norm();
    impl.check_consistency(output, device, note);
    if (impl.solid) {
      impl.check_sides(first, output, device, note);
    } else if (!impl.check_through(output_before, output, moved, note)) {
      continue;
    }
    if (impl.is_comparison_due(output, device, i + number)) {
      ++count.compared_steps;
      if (!impl.is_proved(output.p_SP, device, impl.slop())) impl.check_minimum(output.p_SP, device, before, note);
    }
    if (impl.shows_discontinuities() && i > 0 && before.allFinite()) impl.check_discontinuity(output_before, output, moved, note);
    before = device;
    output_before = output;
  }
  return impl.positions.size();
}

}  // namespace hapton
