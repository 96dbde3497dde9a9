#include "scene/group_expansion.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "scene/similarity.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxShownObjects = 4096;
constexpr std::size_t kDeepestGroup = 16;
constexpr std::size_t kDeepestShown = 256;  // groups around an object, with those that instances show: each level uses some of the stack

// The pose in a table of a group or instance. What the table leaves out is taken from the group or object that it shows.
Similarity pose_of(const GroupSpec& given, const Similarity& shown) {
  return {given.scale.value_or(shown.scale), given.q.value_or(shown.q), given.p.value_or(shown.p)};
}

bool is_in_range(const ObjectSpec& object) {
  const auto is_near = [](const Vec3& p) { return (p.array().abs() <= kMaxLengthM).all(); };
  return object.scale >= 1.0 / kMaxScale && object.scale <= kMaxScale && is_near(object.p_SM) &&
         std::all_of(object.motion.keyframes.begin(), object.motion.keyframes.end(),
                     [&](const KeyframeSpec& one) { return !one.p_SM || is_near(*one.p_SM); });
}

// What is directly in a group, or in no group: indices of the file's objects, instances and groups.
struct Members {
  std::vector<std::size_t> objects;
  std::vector<std::size_t> instances;
  std::vector<std::size_t> groups;

  bool empty() const { return objects.empty() && instances.empty() && groups.empty(); }
};

// What the groups and instances around an object set: its pose, the beginning of its name, and defaults.
struct Surroundings {
  Similarity pose = {};
  std::string prefix = {};  // of the object's name
  std::string material = {};
  std::size_t material_line = 0;
  std::optional<std::array<double, 3>> colour = {};
  std::size_t instance_line = 0;  // of the outermost instance; 0: no instance

  void take_defaults(const GroupSpec& spec) {
    if (!spec.material.empty()) {
      material = spec.material;
      material_line = spec.material_line;
    }
    if (spec.colour) colour = spec.colour;
  }
};

class Expansion {
 public:
  Expansion(const std::vector<ObjectSpec>& objects, const std::vector<GroupSpec>& groups, const std::vector<GroupSpec>& instances)
      : objects_(objects), groups_(groups), instances_(instances), members_(groups.size() + 1) {}

  Result<std::vector<ObjectSpec>> run() {
    for (const auto step : {&Expansion::number_groups, &Expansion::sort_members, &Expansion::check_nesting, &Expansion::name_targets}) {
      if (const auto done = (this->*step)(); !done) return tl::unexpected(done.error());
    }
    if (const auto done = show_members(groups_.size(), {}); !done) return tl::unexpected(done.error());
    return std::move(shown_objects_);
  }

 private:
  // ---- the names in the file

  Result<void> number_groups() {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (group_numbers_.emplace(groups_[g].name, g).second) continue;
      return fail("line {}: there are two groups named '{}': give each its own name", groups_[g].line, printable(groups_[g].name));
    }
    return {};
  }

  // The index of the group with this name. groups_.size(): the name is empty, which means no group.
  Result<std::size_t> find_group(const std::string& name, std::size_t line) const {
    if (name.empty()) return groups_.size();
    if (const auto found = group_numbers_.find(name); found != group_numbers_.end()) return found->second;
    std::vector<std::string_view> known;
    for (const auto& [one, number] : group_numbers_) known.emplace_back(one);
    return fail("line {}: there is no [[group]] named '{}'{}", line, printable(name),
                known.empty() ? ": add it" : similar_word_hint(name, known));
  }

  template <class Spec>
  Result<void> sort(const std::vector<Spec>& specs, std::vector<std::size_t> Members::*list) {
    for (std::size_t i = 0; i < specs.size(); ++i) {
      const auto group = find_group(specs[i].group, specs[i].group_line);
      if (!group) return tl::unexpected(group.error());
      (members_[*group].*list).push_back(i);
    }
    return {};
  }

  Result<void> sort_members() {
    if (const auto done = sort(objects_, &Members::objects); !done) return done;
    if (const auto done = sort(instances_, &Members::instances); !done) return done;
    if (const auto done = sort(groups_, &Members::groups); !done) return done;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!members_[g].empty()) continue;
      return fail("line {}: group '{}' is empty: put objects into it with group = \"{}\", or leave it out", groups_[g].line,
                  printable(groups_[g].name), printable(groups_[g].name));
    }
    return {};
  }

  // The path of a group: "outer/inner/", or "" for no group. Pre: find_group finds all names, and no group is inside itself.
  std::string path_of(const std::string& group) const {
    if (group.empty()) return {};
    return path_of(groups_[group_numbers_.find(group)->second].group) + group + "/";
  }

  Result<void> check_nesting() {
    for (const GroupSpec& group : groups_) {
      std::vector<std::string_view> inside = {group.name};
      for (const GroupSpec* at = &group; !at->group.empty();) {
        at = &groups_[group_numbers_.find(at->group)->second];
        const bool is_again = std::find(inside.begin(), inside.end(), at->name) != inside.end();
        inside.push_back(at->name);
        if (is_again) return fail("line {}: group '{}' is inside itself: {}", group.line, printable(group.name), fmt::join(inside, " in "));
        if (inside.size() > kDeepestGroup) {
          return fail("line {}: group '{}' is inside more than {} others: use fewer", group.line, printable(group.name), kDeepestGroup - 1);
        }
      }
    }
    return {};
  }

  // Lists the objects that 'of' may name, and checks that each 'of' names one object or one group.
  Result<void> name_targets() {
    for (std::size_t o = 0; o < objects_.size(); ++o) targets_[path_of(objects_[o].group) + name_of(objects_[o])].push_back(o);
    std::set<std::string, std::less<>> names;
    for (const GroupSpec& one : instances_) names.insert(path_of(one.group) + one.name);
    for (const GroupSpec& one : instances_) {
      const auto object = targets_.find(one.of);
      const bool is_group = group_numbers_.contains(one.of);
      const std::string of = printable(one.of);
      if (object == targets_.end() && !is_group && names.contains(one.of)) {
        return fail("line {}: '{}' is an instance itself: name the object or the group that it shows", one.of_line, of);
      }
      if (object == targets_.end() && !is_group)
        return fail("line {}: there is no object or group named '{}'{}", one.of_line, of, hint(one));
      if (object != targets_.end() && (is_group || object->second.size() > 1)) {
        return fail("line {}: '{}' is the name of {}: give each its own", one.of_line, of,
                    is_group ? "a group and of an object" : "several objects");
      }
    }
    return {};
  }

  // Proposes a name in place of an unknown 'of'. The full name of an object in a group begins with the group's name.
  std::string hint(const GroupSpec& instance) const {
    std::vector<std::string_view> known;
    for (const auto& [name, objects] : targets_) {
      if (name.ends_with("/" + instance.of)) return fmt::format("; did you mean '{}'?", printable(name));
      known.emplace_back(name);
    }
    for (const auto& [name, number] : group_numbers_) known.emplace_back(name);
    return similar_word_hint(instance.of, known);
  }

  // ---- the objects of the scene

  Result<void> show_members(std::size_t group, const Surroundings& around) {
    for (const std::size_t o : members_[group].objects) {
      ObjectSpec object = objects_[o];
      object.name = name_of(object);
      if (const auto done = show(std::move(object), around); !done) return done;
    }
    for (const std::size_t i : members_[group].instances) {
      if (const auto done = show_instance(instances_[i], around); !done) return done;
    }
    for (const std::size_t g : members_[group].groups) {
      if (const auto done = show_group(g, groups_[g].name, pose_of(groups_[g], {}), around); !done) return done;
    }
    return {};
  }

  // instance: the one that shows the group; its defaults replace those of the group. Null: the group is shown in its own place.
  Result<void> show_group(std::size_t group, const std::string& name, const Similarity& pose, Surroundings around,
                          const GroupSpec* instance = nullptr) {
    if (open_groups_.size() == kDeepestShown) {
      return fail("line {}: '{}' is inside more than {} groups and instances of groups: use fewer",
                  instance != nullptr ? instance->line : groups_[group].line, printable(name), kDeepestShown - 1);
    }
    around.pose = around.pose.then(pose);
    around.prefix += name + "/";
    around.take_defaults(groups_[group]);
    if (instance != nullptr) around.take_defaults(*instance);
    open_groups_.push_back(group);
    const auto done = show_members(group, around);
    open_groups_.pop_back();
    return done;
  }

  Result<void> show_instance(const GroupSpec& instance, Surroundings around) {
    if (around.instance_line == 0) around.instance_line = instance.line;
    if (const auto found = group_numbers_.find(instance.of); found != group_numbers_.end()) {
      if (std::find(open_groups_.begin(), open_groups_.end(), found->second) != open_groups_.end()) {
        return fail("line {}: instance '{}' is inside the group '{}' that it shows: it would contain itself", instance.of_line,
                    printable(around.prefix + instance.name), printable(instance.of));
      }
      return show_group(found->second, instance.name, pose_of(instance, pose_of(groups_[found->second], {})), around, &instance);
    }
    ObjectSpec object = objects_[targets_.find(instance.of)->second.front()];
    const Similarity pose = pose_of(instance, pose_of(object));
    move_by(pose.then(pose_of(object).inverse()), object);
    object.scale = pose.scale;  // exactly, without the rounding of move_by
    object.q_SM = pose.q;
    object.p_SM = pose.p;
    object.name = instance.name;
    if (!instance.material.empty()) {
      object.material = instance.material;
      object.material_line = instance.material_line;
    }
    if (instance.colour) object.colour = *instance.colour;
    object.has_colour = object.has_colour || instance.colour.has_value();
    return show(std::move(object), around);
  }

  Result<void> show(ObjectSpec object, const Surroundings& around) {
    if (!around.prefix.empty()) move_by(around.pose, object);
    object.name = around.prefix + object.name;
    if (object.material.empty()) {
      object.material = around.material;
      object.material_line = around.material_line;
    }
    if (!object.has_colour && around.colour) object.colour = *around.colour;
    object.has_colour = object.has_colour || around.colour.has_value();
    const std::size_t line = around.instance_line != 0 ? around.instance_line : object.mesh_line;
    if (!is_in_range(object)) {
      return fail("line {}: '{}' is {:.3g} times its size, {:.3g} m from the origin: at most {:g} times and {:g} m", line,
                  printable(object.name), object.scale, object.p_SM.norm(), kMaxScale, kMaxLengthM);
    }
    if (const auto [other, is_new] = instance_lines_by_name_.emplace(object.name, around.instance_line); !is_new) {
      return fail("line {}: two objects have the name '{}': in a scene with groups or instances give each its own",
                  around.instance_line == 0 && other->second != 0 ? other->second : line, printable(object.name));
    }
    shown_objects_.push_back(std::move(object));
    if (shown_objects_.size() > kMaxShownObjects)
      return fail("line {}: there are more than {} objects: use fewer instances", line, kMaxShownObjects);
    return {};
  }

  const std::vector<ObjectSpec>& objects_;
  const std::vector<GroupSpec>& groups_;
  const std::vector<GroupSpec>& instances_;
  std::map<std::string, std::size_t, std::less<>> group_numbers_;         // indices of groups, by name
  std::vector<Members> members_;                                          // of each group; the last one: of no group
  std::map<std::string, std::vector<std::size_t>, std::less<>> targets_;  // indices of objects, by their name in the scene
  std::vector<std::size_t> open_groups_;                                  // indices of the groups around what is being shown
  std::map<std::string, std::size_t> instance_lines_by_name_;             // names of all objects shown, with the lines of their instances
  std::vector<ObjectSpec> shown_objects_;
};

}  // namespace

Result<std::vector<ObjectSpec>> expand_groups(const std::vector<ObjectSpec>& objects, const std::vector<GroupSpec>& groups,
                                              const std::vector<GroupSpec>& instances) {
  const bool is_grouped = std::any_of(objects.begin(), objects.end(), [](const ObjectSpec& one) { return !one.group.empty(); });
  if (groups.empty() && instances.empty() && !is_grouped) return objects;
  return Expansion(objects, groups, instances).run();
}

}  // namespace hapton
