#include "core/collision/marked_objects.h"

#include <utility>

#include "core/collision/object_hierarchy.h"

namespace hapton {
namespace {

std::shared_ptr<const ObjectGeometry> with_marks(const std::shared_ptr<const ObjectGeometry>& plain,
                                                 const std::map<std::uint32_t, std::vector<std::uint32_t>>& near) {
  if (near.empty()) return plain;
  auto marked = std::make_shared<ObjectGeometry>(*plain);
  for (const auto& [other, triangles] : near) marked->mark_unwalkable(triangles);
  return marked;
}

}  // namespace

std::vector<std::shared_ptr<const ObjectGeometry>> MarkedObjects::update(const std::vector<std::shared_ptr<const ObjectGeometry>>& objects,
                                                                         std::span<const Box> bounds) {
  objects_.resize(objects.size());
  std::vector<bool> is_new;
  for (std::size_t o = 0; o < objects.size(); ++o) is_new.push_back(objects_[o].plain != objects[o]);
  const ObjectHierarchy hierarchy(bounds);
  std::vector<std::shared_ptr<const ObjectGeometry>> all;
  for (std::uint32_t o = 0; o < objects.size(); ++o) {
    Object& object = objects_[o];
    NearOthers near;
    hierarchy.for_each_overlapping(bounds[o].inflated(ObjectGeometry::kWalkableMargin), [&](std::uint32_t other) {
      if (other == o) return;
      const auto previous = object.near.find(other);
      if (is_new[o] || is_new[other]) {
        auto triangles = objects[o]->find_near(*objects[other], bounds[o]);
        if (!triangles.empty()) near.emplace(other, std::move(triangles));
      } else if (previous != object.near.end()) {
        near.insert(*previous);
      }
    });
    if (is_new[o] || near != object.near) object.marked = with_marks(objects[o], near);
    object.plain = objects[o];
    object.near = std::move(near);
    all.push_back(object.marked);
  }
  return all;
}

}  // namespace hapton
