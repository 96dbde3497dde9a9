#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>

#include "link/codec.h"
#include "link/session_entry.h"
#include "link/shape_parts.h"
#include "recording/haptics_process_count.h"
#include "recording/object_changes.h"

namespace hapton {

// A shape that a program gave to an object, and when the object moves to it. t_s and process: as in RecordedMove.
struct RecordedShape {
  double t_s = 0.0;
  std::int64_t time_ns = 0;  // the same instant by the hub's clock
  std::uint64_t sender = 0;
  std::uint32_t process = 0;
  ShapeStart start;
  // One for each vertex, in metres of the mesh, before scale and pose. Valid during the call of Take. Empty: the recording lacks a part.
  std::span<const ShapePart::Displacement> displacements_m = {};
  // An export has one array for each object and process; this is the shape's index in it. None: the shape is not in it, because it
  // has no displacements, or not as many as the first shape in that array.
  std::optional<std::uint64_t> row = {};
};

// Collects shapes of objects that programs deform from messages of haptics nodes. Passes each to `take` once, in order, when it and those
// before are complete, or without displacements if a part never comes; an hour of shapes does not fit into memory. RT: no. Threads: one.
class RecordingShapeCollector {
 public:
  using Take = std::function<void(const RecordedShape& shape)>;

  // start_ns: the start of the recording.
  explicit RecordingShapeCollector(std::int64_t start_ns) : start_ns_(start_ns) {}

  void add(const SessionEntry& entry, const Datagram* datagram, const Take& take);
  // To be called at the end: passes the remaining shapes to `take`.
  void finish(const Take& take);

 private:
  // Most shapes that wait for parts, their ShapeStart or an earlier shape: of at most 8 objects, a few each.
  static constexpr std::size_t kMaxPending = 64;

  struct PendingShape {
    std::int32_t object = 0;
    std::uint32_t serial = 0;
    ShapeParts parts;
    bool is_started = false;
    RecordedShape shape = {};
  };
  void begin_process(const Take& take);
  PendingShape& find_or_add(std::int32_t object, std::uint32_t serial, std::uint32_t total, const Take& take);
  void pass_first(const Take& take);
  std::optional<std::uint64_t> take_row(const RecordedShape& shape);
  void pass_whole(const Take& take);

  std::int64_t start_ns_;
  HapticsProcessCount processes_;
  std::uint32_t process_ = 0;  // of the shapes below
  std::deque<PendingShape> pending_;
  std::map<std::int32_t, std::uint32_t> started_serials_;  // by object, the serial of the newest ShapeStart
  std::map<std::int32_t, std::uint32_t> passed_serials_;   // by object, the newest serial that `take` got
  struct Rows {
    std::size_t vertices = 0;  // of each shape in the array
    std::uint64_t count = 0;
  };
  std::map<std::int32_t, Rows> rows_;  // by object
};

// The columns of a table of shapes. The column `row` is NaN for a shape without a row.
std::span<const ChangeColumn<RecordedShape>> shape_columns() noexcept;

}  // namespace hapton
