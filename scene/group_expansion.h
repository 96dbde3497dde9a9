#pragma once

#include <vector>

#include "core/base/result.h"
#include "scene/group_reader.h"
#include "scene/object_reader.h"

namespace hapton {

// Turns the objects, groups and instances of a scene file into plain objects, each with its pose in S, material and colour. An object in
// groups is named "OUTER/INNER/OBJECT"; one that an instance shows has the instance's name. Order: first what is in no group, then group by
// group as in the file; in each group objects, instances, groups. Without groups and instances the objects stay as they are. RT: set-up
// only. Error: one line with the line in the file: names that do not exist or exist twice, a group that is empty or contains itself, more
// than 4096 objects, more than 16 nested groups (256 with those that instances show), a pose out of range.
Result<std::vector<ObjectSpec>> expand_groups(const std::vector<ObjectSpec>& objects, const std::vector<GroupSpec>& groups,
                                              const std::vector<GroupSpec>& instances);

}  // namespace hapton
