#include "vision_node/recorded_objects.h"

#include <algorithm>

namespace hapton {

bool RecordedObjects::show(double t_s, std::int64_t scene_time_ns) {
  const std::size_t poses = count_until(index_.poses(), t_s);
  const std::size_t moves = count_until(index_.moves(), t_s + kAheadS);
  bool has_changed = false;
  if (poses < applied_poses_ || moves < applied_moves_) {
    moved_.rewind();
    applied_poses_ = applied_moves_ = 0;
    has_changed = true;
  }
  for (; applied_poses_ < poses; ++applied_poses_) has_changed = moved_.take(index_.poses()[applied_poses_].message) || has_changed;
  for (; applied_moves_ < moves; ++applied_moves_) moved_.take(index_.moves()[applied_moves_].message.to_message());
  if (moved_.has_motion()) has_changed = moved_.set_time(scene_time_ns) || has_changed;
  return has_changed;
}

}  // namespace hapton
