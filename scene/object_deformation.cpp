#include "scene/object_deformation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/collision/deforming_geometry.h"
#include "scene/object_motion.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

constexpr double kSpeedRoundingShare = 1e-9;

MorphTarget place_target(const MorphSpec& morph, const ObjectSpec& object, const SceneFit& fit, const std::vector<Vec3>& vertices) {
  const double scale = fit.scale * object.scale;
  const Mat3 R_SM = object.q_SM.toRotationMatrix();
  const Vec3 centre = fit.apply(object.p_SM + R_SM * (object.scale * morph.centre_m));
  const double radius = scale * morph.radius_m.value_or(0.0);
  MorphTarget target;
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    const Vec3 off = vertices[v] - centre;
    double share = 1.0;
    if (morph.radius_m) {
      const double squared = off.squaredNorm() / (radius * radius);
      if (!(squared < 1.0)) continue;
      share = (1.0 - squared) * (1.0 - squared);
    }
    const Vec3 full = morph.push_m ? Vec3(scale * (R_SM * *morph.push_m))
                                   : Vec3(R_SM * (*morph.stretch - Vec3::Ones()).cwiseProduct(R_SM.transpose() * off));
    const Vec3 displacement = share * full;
    if (displacement.isZero(0.0)) continue;
    target.vertices.push_back(v);
    target.displacements.push_back(displacement);
  }
  return target;
}

// Pre: the times of the keys increase.
double weight_at(const std::vector<MorphSpec::Key>& keys, double time_s) {
  const auto after = std::ranges::upper_bound(keys, time_s, {}, &MorphSpec::Key::time_s);
  if (after == keys.begin()) return keys.front().weight;
  if (after == keys.end()) return keys.back().weight;
  const MorphSpec::Key& from = *(after - 1);
  return from.weight + (time_s - from.time_s) / (after->time_s - from.time_s) * (after->weight - from.weight);
}

// The weights of all morphs at each time at which one of them has a key.
std::vector<MorphKey> join_keys(const std::vector<MorphSpec>& morphs) {
  std::set<double> times;
  for (const MorphSpec& morph : morphs) {
    for (const MorphSpec::Key& key : morph.keys) times.insert(key.time_s);
  }
  std::vector<MorphKey> keys;
  for (const double time : times) {
    keys.push_back({time, {}});
    for (const MorphSpec& morph : morphs) keys.back().weights.push_back(weight_at(morph.keys, time));
  }
  return keys;
}

// The largest distance of a vertex from the pivot, over the shapes at all keys.
double radius_of_shapes(const Vec3& pivot, const TriangleMesh& mesh, const MeshDeformation& deformation) {
  double most = 0.0;
  for (const MorphKey& key : deformation.keys()) {
    for (const Vec3& vertex : deformation.vertices_at(mesh.vertices, deformation.weights_at(key.time_s))) {
      most = std::max(most, (vertex - pivot).norm());
    }
  }
  return most;
}

double fastest_motion(const KeyframeMotion* motion, const TriangleMesh& mesh, const MeshDeformation& deformation) {
  if (motion == nullptr) return 0.0;
  const double radius_m = radius_of_shapes(motion->pivot(), mesh, deformation);
  double fastest = 0.0;
  for (std::size_t i = 1; i < motion->keyframes().size(); ++i) fastest = std::max(fastest, motion->fastest_m_per_s(i - 1, radius_m));
  return fastest;
}

Result<void> check_speed(const MeshDeformation& deformation, double motion_m_per_s, const std::string& name) {
  const auto& keys = deformation.keys();
  const double speed_left = kMaxSurfaceSpeed - motion_m_per_s;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const double fastest = deformation.fastest_per_s(i - 1);
    if (fastest + motion_m_per_s <= kMaxSurfaceSpeed * (1.0 + kSpeedRoundingShare)) continue;
    const double seconds = keys[i].time_s - keys[i - 1].time_s;
    if (motion_m_per_s > 0.0) {
      return fail(
          "before {:g} s '{}' deforms at up to {:.3g} m/s and moves at up to {:.3g}; a surface may move at {:g} m/s at most: "
          "give both more time",
          keys[i].time_s, name, fastest, motion_m_per_s, kMaxSurfaceSpeed);
    }
    return fail(
        "from {:g} to {:g} s '{}' deforms at up to {:.3g} m/s; a surface may move at {:g} m/s at most: give it {:.3f} s "
        "or more",
        keys[i - 1].time_s, keys[i].time_s, name, fastest, kMaxSurfaceSpeed, std::ceil(1e3 * seconds * fastest / speed_left) / 1e3);
  }
  return {};
}

// The deformation by the morphs of a scene file.
Result<MeshDeformation> place_morphs(const ObjectSpec& object, const std::string& name, const SceneFit& fit, const TriangleMesh& mesh) {
  std::vector<MorphTarget> targets;
  for (const MorphSpec& morph : object.morphs) {
    targets.push_back(place_target(morph, object, fit, mesh.vertices));
    if (!targets.back().vertices.empty()) continue;
    return fail("line {}: this morph moves no vertex of '{}': check its center_m and radius_m", morph.line, name);
  }
  return MeshDeformation(std::move(targets), join_keys(object.morphs), object.motion.loops);
}

// Assigns displacements to the vertices in_file. The mesh file repeats a vertex for each of its normals; all copies must move together.
Result<std::vector<std::vector<Vec3>>> match_vertices(const MeshMorphs& morphs, const std::vector<Vec3>& in_file, const std::string& name) {
  constexpr double kSame = 1e-6;  // of the longest displacement: numbers in a file have seven digits
  const auto key_of = [](const Vec3& p) { return std::array{p.x(), p.y(), p.z()}; };
  std::map<std::array<double, 3>, std::size_t> places;
  for (std::size_t v = 0; v < in_file.size(); ++v) places.emplace(key_of(in_file[v]), v);
  std::vector<std::vector<Vec3>> matched(morphs.displacements.size(), std::vector<Vec3>(in_file.size(), Vec3::Zero()));
  std::vector<bool> is_matched(in_file.size(), false);
  double longest = 0.0;
  for (const auto& target : morphs.displacements) {
    for (const Vec3& displacement : target) longest = std::max(longest, displacement.norm());
  }
  for (std::size_t i = 0; i < morphs.at_rest.size(); ++i) {
    const auto place = places.find(key_of(morphs.at_rest[i]));
    if (place == places.end()) continue;  // belongs to no triangle
    for (std::size_t t = 0; t < matched.size(); ++t) {
      Vec3& displacement = matched[t][place->second];
      if (is_matched[place->second] && (displacement - morphs.displacements[t][i]).norm() > kSame * longest) {
        return fail("'{}' would be torn at ({:.4g}, {:.4g}, {:.4g}) m: its morph targets move vertices at this point apart", name,
                    morphs.at_rest[i].x(), morphs.at_rest[i].y(), morphs.at_rest[i].z());
      }
      displacement = morphs.displacements[t][i];
    }
    is_matched[place->second] = true;
  }
  if (std::find(is_matched.begin(), is_matched.end(), false) != is_matched.end()) {
    return fail("'{}' deforms, and cracks of it were sealed: add seal_cracks = false, or repair it", name);
  }
  return matched;
}

// The deformation by an animation of a mesh file. Targets whose weight is 0 at all keys are left out.
Result<MeshDeformation> place_animation(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                        const std::vector<Vec3>& in_file) {
  const auto& [morphs, keys] = *object.animated_morphs;
  const auto matched = match_vertices(morphs, in_file, name);
  if (!matched) return tl::unexpected(matched.error());
  const Mat3 to_scene = fit.scale * object.scale * object.q_SM.toRotationMatrix();
  std::vector<MorphTarget> targets;
  std::vector<MorphKey> placed;
  for (const MorphKey& key : keys) placed.push_back({key.time_s / object.motion.animation_speed, {}});
  for (std::size_t t = 0; t < matched->size(); ++t) {
    if (std::all_of(keys.begin(), keys.end(), [t](const MorphKey& key) { return key.weights[t] == 0.0; })) continue;
    MorphTarget target;
    for (std::uint32_t v = 0; v < in_file.size(); ++v) {
      if ((*matched)[t][v].isZero(0.0)) continue;
      target.vertices.push_back(v);
      target.displacements.push_back(to_scene * (*matched)[t][v]);
    }
    if (target.vertices.empty()) continue;
    targets.push_back(std::move(target));
    for (std::size_t k = 0; k < keys.size(); ++k) placed[k].weights.push_back(keys[k].weights[t]);
  }
  if (targets.empty()) return fail("animation '{}' does not deform '{}'", printable(object.motion.animation), name);
  if (targets.size() > MeshDeformation::kMaxTargets) {
    return fail("animation '{}' uses {} morph targets of '{}': at most {}", printable(object.motion.animation), targets.size(), name,
                MeshDeformation::kMaxTargets);
  }
  return MeshDeformation(std::move(targets), std::move(placed), object.motion.loops);
}

Result<void> check_deformation(const MeshDeformation& deformation, const std::string& name, const TriangleMesh& mesh,
                               const KeyframeMotion* motion) {
  if (deformation.loops() && deformation.keys().front().weights != deformation.keys().back().weights) {
    return fail(
        "'{}' does not end with the weights at its beginning, so it would jump at each repetition: make them equal, or leave out 'loop'",
        name);
  }
  if (auto checked = check_speed(deformation, fastest_motion(motion, mesh, deformation), name); !checked) return checked;
  if (auto checked = check_shapes(mesh, deformation); !checked) {
    return fail("'{}' deforms, and {}: repair the mesh, or deform it less", name, checked.error().what);
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<const MeshDeformation>> make_deformation(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                                const std::vector<Vec3>& in_file, const TriangleMesh& mesh,
                                                                const KeyframeMotion* motion) {
  if (!object.deforms()) return std::shared_ptr<const MeshDeformation>();
  const std::string shown = printable(name);
  auto placed = object.morphs.empty() ? place_animation(object, shown, fit, in_file) : place_morphs(object, shown, fit, mesh);
  const std::size_t line = object.morphs.empty() ? object.motion.animation_line : object.morphs.front().line;
  if (!placed)
    return placed.error().what.starts_with("line ") ? fail("{}", placed.error().what) : fail("line {}: {}", line, placed.error().what);
  if (const auto checked = check_deformation(*placed, shown, mesh, motion); !checked)
    return fail("line {}: {}", line, checked.error().what);
  return std::make_shared<const MeshDeformation>(std::move(*placed));
}

MeshDeformation deform_others(const ObjectSpec& object, const SceneFit& fit, const std::vector<Vec3>& vertices) {
  std::vector<MorphTarget> targets;
  for (const MorphSpec& morph : object.morphs) targets.push_back(place_target(morph, object, fit, vertices));
  return MeshDeformation(std::move(targets), join_keys(object.morphs), object.motion.loops);
}

}  // namespace hapton
