#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "haptic_step/haptics_step.h"
#include "link/messages.h"
#include "link/shape_parts.h"
#include "scene/program_shape.h"
#include "tools/session/first_shapes.h"

namespace hapton {

// The settings of an object that programs deform, in the scene that a setup names. Null: programs do not deform the object, or the scene is
// unknown.
using FindProgramShape = std::function<std::shared_ptr<const ProgramShape>(const HapticsSetup& setup, std::int32_t object)>;

// The shapes of objects that haptics nodes announced in a recording, as its entries come: vertices first, then the start. Kept until they
// are used. RT: no. Threads: one.
class RecordedShapes {
 public:
  using FindShape = std::function<std::shared_ptr<const ProgramShape>(std::int32_t object)>;

  // The shapes that were in use when the recording began. Pre: nothing was added yet.
  void use_first(FirstShapes first) { first_ = std::move(first); }

  // sender: of the datagram. One that was applied before is left out.
  void add(std::uint64_t sender, const ObjectShape& shape);
  void add(std::uint64_t sender, const ShapeStart& start);

  // The first force of a sender includes all shapes up to that serial.
  void begin(std::uint64_t sender, std::uint32_t serial);

  // Begins the motion of that serial in the step, as the haptics node did. False: the recording lacks a part of it or its start, or it is
  // not of that scene; or the step is not where the node was. Pre: called with one serial after the other.
  bool apply(std::uint64_t sender, std::uint32_t serial, HapticsStep& step, const FindShape& find_shape);
  // The same for all up to that serial, without a step, as it is not known where the surfaces are. Time: of those that the recording has,
  // as a damaged one may name any serial. Pre: serial is above the last one.
  void pass(std::uint64_t sender, std::uint32_t serial);

  // Whether it is known where the surfaces of these objects are at that scene time: both shapes of a motion, or the last one after its end.
  bool knows(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns) const;
  // Puts them there. False: they cannot be there. Pre: knows(); in the step all are at rest.
  bool restore(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns, HapticsStep& step,
               const FindShape& find_shape) const;

 private:
  // One that has begun.
  struct Begun {
    ShapeStart start;
    std::optional<ShapeParts> shape;  // whole; none: the recording lacks it
  };
  struct Sender {
    std::map<std::uint32_t, ShapeParts> shapes = {};  // by serial
    std::map<std::uint32_t, ShapeStart> starts = {};
    std::map<std::int32_t, std::deque<Begun>> begun = {};  // the last two of each object
    std::uint32_t applied = 0;                             // all up to this serial
  };
  // Of one object: its last motion, and the shape from which it begins; null: at rest.
  struct Motion {
    const Begun* last = nullptr;
    const Begun* before = nullptr;
  };
  static std::optional<Motion> find_motion(const Sender& own, int object, std::int64_t scene_time_ns);
  static const Begun* take(Sender& own, std::uint32_t serial);
  static void push(Sender& own, Begun begun);

  FirstShapes first_;
  std::map<std::uint64_t, Sender> senders_;
};

}  // namespace hapton
