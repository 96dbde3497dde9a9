#include "scene/animated_object.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "scene/text_cursor.h"

namespace hapton {
namespace {

Result<const MeshAnimation*> find_animation(const std::string& name, const MeshFile& file) {
  std::string names;
  for (const MeshAnimation& each : file.animations) {
    if (each.name == name) return &each;
    names += (names.empty() ? "'" : ", '") + printable(each.name) + "'";
  }
  if (names.empty()) return fail("has no animations: leave 'animation' out, or give it keyframes");
  return fail("has no animation '{}': it has {}", printable(name), names);
}

// How long a motion takes from its last pose back to the first at its mean speed: 0 if it ends at the first. Exporters leave out the frame
// that would repeat the first.
double find_seam_s(const KeyframeMotion& motion) {
  constexpr double kSame = 1e-6;  // share of the path, below which the ends are equal: numbers of a file have seven digits
  const std::vector<Keyframe>& keyframes = motion.keyframes();
  double path_m = 0.0;
  double turned_rad = 0.0;
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    path_m += (keyframes[i].p_S - keyframes[i - 1].p_S).norm();
    turned_rad += keyframes[i].turn.angularDistance(keyframes[i - 1].turn);
  }
  const Keyframe& first = keyframes.front();
  const Keyframe& last = keyframes.back();
  const double shift = path_m > 0.0 ? (last.p_S - first.p_S).norm() / path_m : 0.0;
  const double turn = turned_rad > 0.0 ? last.turn.angularDistance(first.turn) / turned_rad : 0.0;
  const double share = std::max(shift, turn);
  return share > kSame ? share * (last.time_s - first.time_s) : 0.0;
}

// All parts of an animation begin again together, after the longest way back. An animation with a part that deforms has no way back.
void close_loops(std::vector<ObjectSpec>& parts) {
  double seam_s = 0.0;
  for (const ObjectSpec& part : parts) {
    if (part.animated_morphs != nullptr) return;
    if (part.animated) seam_s = std::max(seam_s, find_seam_s(*part.animated));
  }
  for (ObjectSpec& part : parts) part.motion.seam_s = seam_s;
}

}  // namespace

Result<std::vector<ObjectSpec>> split_animated(const ObjectSpec& object, const std::string& name, const MeshFile& file) {
  const auto animation = find_animation(object.motion.animation, file);
  if (!animation) return tl::unexpected(animation.error());
  ObjectSpec still = object;
  still.name = name;
  still.motion = {};
  std::vector<ObjectSpec> moving;
  for (const MeshPart& part : file.parts) {
    if (!object.part.empty() && !is_named(part, object.part)) continue;
    const auto moved = (*animation)->motions.find(part.node);
    const auto weights = (*animation)->weights.find(part.node);
    const auto morphs = file.morphs.find(part.node);
    const bool deforms = weights != (*animation)->weights.end() && morphs != file.morphs.end();
    const auto motion = moved != (*animation)->motions.end() ? std::optional(moved->second) : std::nullopt;
    if (!motion && !deforms) {
      still.nodes.push_back(part.node);
      continue;
    }
    // A part that deforms is an object of its own.
    const auto same = [&](const ObjectSpec& each) { return !deforms && each.animated_morphs == nullptr && each.animated == motion; };
    const auto own = [&](const ObjectSpec& each) { return deforms && each.nodes == std::vector{part.node}; };
    auto found = std::find_if(moving.begin(), moving.end(), [&](const ObjectSpec& each) { return same(each) || own(each); });
    if (found == moving.end()) {
      found = moving.insert(moving.end(), object);
      found->name = name + "/" + full_name(part);
      found->animated = motion;
      if (deforms) found->animated_morphs = std::make_shared<const AnimatedMorphs>(AnimatedMorphs{morphs->second, weights->second});
    }
    if (!own(*found)) found->nodes.push_back(part.node);
  }
  if (moving.empty()) return fail("animation '{}' moves nothing here: leave it out", printable(object.motion.animation));
  if (object.motion.loops) close_loops(moving);
  if (!still.nodes.empty()) moving.insert(moving.begin(), std::move(still));
  return moving;
}

}  // namespace hapton
