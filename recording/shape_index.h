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
  // Positions (SessionReader::position) of the first and the last entry with one of its parts. None: the recording has no part.
  std::optional<std::uint64_t> first_position = {};
  std::uint64_t last_position = 0;
};

// The shapes of objects that programs deform, by time, without their vertices: those of an hour do not fit into memory. A shape that an
// object already had when the recording began is announced a moment later; its time here precedes all others. Times as in RecordingIndex.
// RT: no. Threads: const calls from any number.
class ShapeIndex {
 public:
  // To be called with the messages of a recording, in their order. position: that of the message's entry.
  void add(const ObjectShape& shape, std::uint64_t position);
  void add(const ShapeStart& start, double t_s);
  void add(const ForceCommand& force);

  // All shapes in ascending order of time, without repetitions. Serial 0: another haptics process begins, with all objects at rest.
  std::span<const Timed<IndexedShape>> all() const { return shapes_; }

  // The newest shape of an object whose motion began before that scene time, and may have ended, of those recorded until ahead_s after t_s:
  // a motion may begin, in scene time, shortly before it is recorded. Null: the object is at rest.
  const IndexedShape* find(std::int32_t object, double t_s, double ahead_s, std::int64_t scene_time_ns) const;
  // The shape from which that motion begins. Null: it is not in the recording, or the motion begins at rest.
  const IndexedShape* find_before(const ShapeStart& start) const;

 private:
  // The parts of a shape that have come.
  struct Parts {
    std::uint32_t source = 0;
    std::uint32_t serial = 0;
    std::int32_t object = 0;
    std::bitset<ShapePart::kMaxParts> received = {};
    std::uint64_t first_position = 0;
    std::uint64_t last_position = 0;
  };
  // Most shapes in open_parts_, the newest of which parts have come: enough for a few incomplete ones of each of at most 8 objects.
  static constexpr std::size_t kMaxOpen = 64;
  // Shapes at the beginning of shapes_ that may be from before the recording: one of each of at most 8 objects.
  static constexpr std::size_t kMaxFirst = 8;

  IndexedShape* find_shape(std::uint32_t source, std::int32_t object, std::uint32_t serial);
  const Timed<IndexedShape>* find_newest(std::uint32_t source, std::int32_t object) const;

  std::vector<Timed<IndexedShape>> shapes_;
  std::deque<Parts> open_parts_;
  std::optional<std::int64_t> first_scene_time_ns_;
  std::uint32_t first_source_ = 0;
};

}  // namespace hapton
