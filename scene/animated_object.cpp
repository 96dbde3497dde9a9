#include "scene/animated_object.h"

#include <algorithm>

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
    const auto motion = (*animation)->motions.find(part.node);
    if (motion == (*animation)->motions.end()) {
      still.nodes.push_back(part.node);
      continue;
    }
    const auto same = [&](const ObjectSpec& each) { return each.animated == motion->second; };
    auto found = std::find_if(moving.begin(), moving.end(), same);
    if (found == moving.end()) {
      found = moving.insert(moving.end(), object);
      found->name = name + "/" + full_name(part);
      found->animated = motion->second;
    }
    found->nodes.push_back(part.node);
  }
  if (moving.empty()) return fail("animation '{}' moves nothing here: leave it out", printable(object.motion.animation));
  if (!still.nodes.empty()) moving.insert(moving.begin(), std::move(still));
  return moving;
}

}  // namespace hapton
