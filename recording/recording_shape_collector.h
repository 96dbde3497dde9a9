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
#include "recording/object_changes.h"

namespace hapton {

// A shape that a program gave to an object, with the motion to it. t_s, process: as of RecordedMove.
struct RecordedShape {
  double t_s = 0.0;
  std::int64_t time_ns = 0;  // the same by the hub's clock
  std::uint64_t sender = 0;
  std::uint32_t process = 0;
  ShapeStart start;
  // By vertex; m of the mesh, before scale and pose. Empty: the recording lacks a part of it.
  std::span<const ShapePart::Displacement> displacements_m = {};
  // Counts the shapes of this object and process that have vertices, as many as the first of them; none: it has not. So an export has one
  // array for each object and process.
  std::optional<std::uint64_t> row = {};
};

// The shapes of objects that programs deform, from what haptics nodes announced: each once, as soon as all of it has come, or without its
// vertices if these do not come. Those of an hour do not fit into memory, so they are handed on. RT: no. Threads: one.
class RecordingShapeCollector {
 public:
  using Take = std::function<void(const RecordedShape& shape)>;

  // start_ns: of the recording.
  explicit RecordingShapeCollector(std::int64_t start_ns) : start_ns_(start_ns) {}

  void add(const SessionEntry& entry, const Datagram* datagram, const Take& take);
  // At the end: what is left.
  void finish(const Take& take);

 private:
  // Of 8 objects at most, each with a few on their way.
  static constexpr std::size_t kMaxOpen = 64;

  struct Open {
    std::int32_t object = 0;
    std::uint32_t serial = 0;
    ShapeParts parts;
    bool is_started = false;
    RecordedShape shape = {};
  };
  void begin_process(std::uint32_t source, const Take& take);
  Open& open(std::int32_t object, std::uint32_t serial, std::uint32_t total, const Take& take);
  void close_first(const Take& take);
  std::optional<std::uint64_t> take_row(const RecordedShape& shape);
  void hand_on_whole(const Take& take);

  std::int64_t start_ns_;
  std::uint32_t source_ = 0;
  std::uint32_t process_ = 0;
  std::deque<Open> open_;
  std::map<std::int32_t, std::uint32_t> started_;  // the newest serial, by object
  std::map<std::int32_t, std::uint32_t> closed_;   // ... that was handed on
  struct Rows {
    std::size_t vertices = 0;  // of each
    std::uint64_t count = 0;
  };
  std::map<std::int32_t, Rows> rows_;  // by object
};

// `row` is NaN where there is none.
std::span<const ChangeColumn<RecordedShape>> shape_columns() noexcept;

}  // namespace hapton
