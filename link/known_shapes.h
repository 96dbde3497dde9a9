#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "link/messages.h"
#include "link/move_source.h"
#include "link/shape_parts.h"

namespace hapton {

// The shapes of objects that programs deform, from what the haptics node sends: where all vertices are at a scene time. The last few
// motions are kept, for pictures of earlier samples. RT: no. Threads: one.
class KnownShapes {
 public:
  KnownShapes() = default;
  // totals: of each object of the scene, the vertices of its mesh; 0: programs do not deform it.
  explicit KnownShapes(std::vector<std::uint32_t> totals) : objects_(totals.size()), totals_(std::move(totals)) {}

  // arrival: as HubClient::last_arrival of this message. One of another scene, or of a haptics process that was replaced, is left out.
  void take(const ObjectShape& shape, Arrival arrival);
  void take(const ShapeStart& start, Arrival arrival);

  // Between which shapes an object is: serials, 0 at rest. Shapes that are not known whole are left out: the object is then at the next one
  // that is.
  struct Place {
    std::uint32_t before = 0;
    std::uint32_t to = 0;
    double share = 1.0;  // of the motion
    friend bool operator==(const Place&, const Place&) = default;
  };
  // At a scene time; none: no shape is known for it. Pre: an object of the scene.
  std::optional<Place> find(std::size_t object, std::int64_t scene_time_ns) const;
  // By vertex of the mesh. Pre: as find() returned it, with nothing taken since.
  std::vector<ShapePart::Displacement> displacements_m(std::size_t object, const Place& place) const;

  // For the newest shape of an object, while it is not whole.
  std::optional<ShapeStatus> take_request(std::int64_t now_ns);

 private:
  // The newest of an object; a choice.
  static constexpr std::size_t kMostStarts = 4;
  static constexpr std::size_t kMostShapes = 8;
  static constexpr std::int64_t kPartTimeoutNs = 60'000'000;  // the parts may be on their way
  static constexpr std::int64_t kRequestEveryNs = 200'000'000;

  struct Object {
    std::deque<ShapeStart> starts;  // the newest, by serial
    std::map<std::uint32_t, ShapeParts> shapes;
    std::int64_t request_ns = 0;  // not before; 0: not looked at since its newest start
  };

  bool is_of_scene(std::int32_t object, std::uint32_t total) const;
  bool note_source(std::uint32_t source, Arrival arrival);
  const ShapeParts* find_whole(const Object& object, std::uint32_t serial) const;
  bool is_known(const Object& object, std::uint32_t serial) const { return serial == 0 || find_whole(object, serial) != nullptr; }

  MoveSource source_;
  std::uint32_t process_ = 0;
  std::vector<Object> objects_;
  std::vector<std::uint32_t> totals_;
};

}  // namespace hapton
