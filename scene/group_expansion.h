#pragma once

#include <vector>

#include "core/base/result.h"
#include "scene/group_reader.h"
#include "scene/object_reader.h"

namespace hapton {

// What a scene file with groups and instances is read as: plain objects, each with its pose in S, its material and its colour. An object in
// groups is named "OUTER/INNER/OBJECT", one that an instance shows after the instance. Order: what is in no group first, then group by
// group as in the file; in each of them objects, instances, groups. Without groups and instances the objects stay as they are.
// RT: set-up only. Error: one line with the line in the file: names that do not exist or exist twice, a group that contains itself or
// nothing, more than 4096 objects, an object in more than 256 groups and instances of groups.
Result<std::vector<ObjectSpec>> expand_groups(const std::vector<ObjectSpec>& objects, const std::vector<GroupSpec>& groups,
                                              const std::vector<GroupSpec>& instances);

}  // namespace hapton
