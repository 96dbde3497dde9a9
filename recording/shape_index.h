#pragma once

#include <bitset>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "link/messages.h"
#include "recording/timed.h"

namespace hapton {

// A shape that a program gave to an object, and where in the recording its vertices are.
struct IndexedShape {
  ShapeStart start;
  // The entries with its parts are from the first position to the last one, among others (SessionReader::position). None: it has none.
  std::optional<std::uint64_t> first_position = {};
  std::uint64_t last_position = 0;
};

// The shapes of objects that programs deform, by time, without their vertices: those of an hour do not fit into memory. A shape that an
// object had when the recording began, which is announced a moment later, is there from before its beginning. Times as in RecordingIndex.
// RT: no. Threads: const calls from any number.
class ShapeIndex {
 public:
  // Of the entries of a recording, in their order. position: of the entry.
  void add(const ObjectShape& shape, std::uint64_t position);
  void add(const ShapeStart& start, double t_s);
  void add(const ForceCommand& force);

  // In ascending order of time, without repetitions. Serial 0: another haptics process begins, with all objects at rest.
  std::span<const Timed<IndexedShape>> all() const { return shapes_; }

  // The motion that an object is in at a time, or has ended: the last one that began before that scene time, of those that were recorded up
  // to ahead_s later, as one may begin, in scene time, shortly before it is recorded. Null: it is at rest.
  const IndexedShape* find(std::int32_t object, double t_s, double ahead_s, std::int64_t scene_time_ns) const;
  // The one of that serial, from which a motion begins. Null: it is not in the recording, or 0.
  const IndexedShape* find_before(const ShapeStart& start) const;

 private:
  // Parts that have come of a shape.
  struct Parts {
    std::uint32_t source = 0;
    std::uint32_t serial = 0;
    std::int32_t object = 0;
    std::bitset<ShapePart::kMaxParts> received = {};
    std::uint64_t first_position = 0;
    std::uint64_t last_position = 0;
  };
  // Shapes of which some parts have come, but not all: of at most 8 objects, a few each.
  static constexpr std::size_t kMaxOpen = 64;
  static constexpr std::size_t kMaxFirst = 8;

  IndexedShape* find_shape(std::uint32_t source, std::int32_t object, std::uint32_t serial);
  const Timed<IndexedShape>* find_newest(std::uint32_t source, std::int32_t object) const;

  std::vector<Timed<IndexedShape>> shapes_;
  std::deque<Parts> open_;
  std::optional<std::int64_t> first_scene_time_ns_;
  std::uint32_t first_source_ = 0;
};

}  // namespace hapton
