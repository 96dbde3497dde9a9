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
    // What deforms is an object of its own.
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
  if (!still.nodes.empty()) moving.insert(moving.begin(), std::move(still));
  return moving;
}

}  // namespace hapton
