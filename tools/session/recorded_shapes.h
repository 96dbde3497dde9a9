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

// Returns the settings of an object that programs deform, in the scene that a setup names. Null: programs do not deform the object, or the
// scene is unknown.
using FindProgramShape = std::function<std::shared_ptr<const ProgramShape>(const HapticsSetup& setup, std::int32_t object)>;

// The shapes that haptics nodes announced in a recording, as its entries come: of each shape first the vertices, then the start. They are
// kept until they are used. RT: no. Threads: one.
class RecordedShapes {
 public:
  using FindShape = std::function<std::shared_ptr<const ProgramShape>(std::int32_t object)>;

  // The shapes that were in use when the recording began. Pre: nothing was added yet.
  void use_first(FirstShapes first) { first_ = std::move(first); }

  // sender: that of the datagram. A shape that was applied before is ignored.
  void add(std::uint64_t sender, const ObjectShape& shape);
  void add(std::uint64_t sender, const ShapeStart& start);

  // Starts with the first force of a sender: all shapes up to that serial were begun before it, and are those of use_first().
  void begin(std::uint64_t sender, std::uint32_t serial);

  // Begins the motion to the shape with that serial in the step, as the haptics node did. False: the recording lacks a part of the shape or
  // its start, or the shape does not fit this scene, or too many motions wait in the step. Pre: serial is the one after the last.
  bool apply(std::uint64_t sender, std::uint32_t serial, HapticsStep& step, const FindShape& find_shape);
  // Passes over all shapes up to that serial without a step, for a replay that does not know where the surfaces are. Time: proportional to
  // the shapes in the recording, since a damaged recording may name any serial. Pre: serial is above the last one.
  void skip_to(std::uint64_t sender, std::uint32_t serial);

  // Whether it is known where the surfaces of these objects are at that scene time: by both shapes of a motion, or after it by the last.
  bool knows(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns) const;
  // Moves the surfaces there. False: the step cannot do it. Pre: knows(); in the step all these objects are at rest.
  bool restore(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns, HapticsStep& step,
               const FindShape& find_shape) const;

 private:
  // A motion that has begun.
  struct BegunMotion {
    ShapeStart start;
    std::optional<ShapeParts> shape;  // complete; none: the recording lacks a part of it
  };
  struct SenderShapes {
    std::map<std::uint32_t, ShapeParts> shapes = {};  // by serial
    std::map<std::uint32_t, ShapeStart> starts = {};
    std::map<std::int32_t, std::deque<BegunMotion>> begun_motions = {};  // the last two of each object
    std::uint32_t applied_serial = 0;                                    // all shapes up to this serial were applied or passed over
  };
  // The last motion of an object, and the one that ends in the shape from which it begins; null: it begins at rest, or has ended.
  struct Motion {
    const BegunMotion* last = nullptr;
    const BegunMotion* before = nullptr;
  };
  static std::optional<Motion> find_motion(const SenderShapes& sender_shapes, int object, std::int64_t scene_time_ns);
  static const BegunMotion* begin_motion(SenderShapes& sender_shapes, std::uint32_t serial);
  static void push(SenderShapes& sender_shapes, BegunMotion begun);

  FirstShapes first_;
  std::map<std::uint64_t, SenderShapes> senders_;
};

}  // namespace hapton
