#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "link/haptics_source.h"
#include "link/messages.h"
#include "link/shape_parts.h"

namespace hapton {

// The shapes of objects that programs deform, from what the haptics node sends: where all vertices are at a scene time. The last few
// motions are kept, for pictures of earlier samples. RT: no. Threads: one.
class KnownShapes {
 public:
  KnownShapes() = default;
  // totals: for each object of the scene, the number of vertices of its mesh; 0: programs do not deform it.
  explicit KnownShapes(const std::vector<std::uint32_t>& totals);

  // Programs deform this object of the scene, too. If it has had another number of vertices, what is known of it is dropped.
  void add_object(std::size_t object, std::uint32_t total);
  std::size_t count_objects() const { return objects_.size(); }
  // Forgets all other objects.
  void keep_objects(const std::set<std::size_t>& objects);

  // arrival: HubClient::last_arrival() of this message. Messages of another scene, or of a replaced haptics process, are left out.
  void take(const ObjectShape& shape, Arrival arrival);
  void take(const ShapeStart& start, Arrival arrival);

  // The two shapes between which an object is: serials, 0 at rest. If only one of the two is known whole, the object is at that
  // one.
  struct Place {
    std::uint32_t before = 0;
    std::uint32_t to = 0;
    double share = 1.0;  // of the motion
    friend bool operator==(const Place&, const Place&) = default;
  };
  // The place at a scene time; none: neither of the two shapes is known whole, or programs do not deform the object.
  std::optional<Place> find(std::size_t object, std::int64_t scene_time_ns) const;
  // The newest start of an object, whether its shape is known or not; null: none was announced.
  const ShapeStart* newest_start(std::size_t object) const;
  // The start of that serial; null: it is not known.
  const ShapeStart* find_start(std::size_t object, std::uint32_t serial) const;
  // The first start after that serial that has not ended at that time, else the newest, among shapes that are known whole; null: none.
  const ShapeStart* find_next(std::size_t object, std::uint32_t serial, std::int64_t scene_time_ns) const;
  // Displacements from rest (ShapePart), by vertex of the mesh. Pre: place is as find() returned it, with nothing taken since.
  std::vector<ShapePart::Displacement> displacements_m(std::size_t object, const Place& place) const;

  // A request for the missing parts of an object's newest shape, if one is due.
  std::optional<ShapeStatus> take_request(std::int64_t now_ns);
  // For a program that needs each shape before it begins: requests for the missing parts of recently announced shapes, once for each.
  void take_requests_ahead(std::int64_t now_ns, std::vector<ShapeStatus>& into);

 private:
  // The newest of an object are kept: those that wait for their start (StreamedGeometry::kMaxWaiting), and a few for earlier pictures.
  static constexpr std::size_t kMaxStarts = 12;
  static constexpr std::size_t kMaxShapes = 16;
  // Choices: shorter times repair a loss sooner, and request more parts that were only late.
  static constexpr std::int64_t kPartTimeoutNs = 60'000'000;  // from an announced start to the first request: the parts may be on their way
  static constexpr std::int64_t kRequestEveryNs = 200'000'000;  // between two requests
  static constexpr std::int64_t kReorderedNs = 25'000'000;      // from a start to the request ahead: parts sent before it may come after it
  static constexpr std::size_t kMaxRuns = 8;                    // runs of missing parts of a shape, in requests ahead

  struct Object {
    std::uint32_t total = 0;             // vertices
    std::deque<ShapeStart> starts = {};  // the newest, by serial
    std::map<std::uint32_t, ShapeParts> shapes = {};
    std::int64_t request_ns = 0;                                  // no request before this time; 0: not set since its newest start
    std::map<std::uint32_t, std::int64_t> request_ahead_ns = {};  // by serial: when to request it ahead; 0: done
  };

  Object* find_object(std::int32_t object, std::uint32_t total);
  const Object* find_object(std::size_t object) const;
  bool note_source(std::uint32_t source, Arrival arrival);
  void request_runs(std::size_t object, const ShapeStart& start, const ShapeParts* parts, std::vector<ShapeStatus>& into) const;
  const ShapeParts* find_whole(const Object& object, std::uint32_t serial) const;
  bool is_known(const Object& object, std::uint32_t serial) const { return serial == 0 || find_whole(object, serial) != nullptr; }

  HapticsSource source_;
  std::uint32_t process_ = 0;
  std::map<std::size_t, Object> objects_;  // those that programs deform
};

}  // namespace hapton
