#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "haptic_step/haptics_step.h"
#include "link/messages.h"
#include "link/shape_parts.h"
#include "scene/program_shape.h"

namespace hapton {

// What a shape of an object means in the scene that a setup names. Null: programs do not deform the object, or the scene is unknown.
using FindProgramShape = std::function<std::shared_ptr<const ProgramShape>(const HapticsSetup& setup, std::int32_t object)>;

// The shapes of objects that haptics nodes announced in a recording, as its entries come: vertices first, then the start. Kept until they
// are used. RT: no. Threads: one.
class RecordedShapes {
 public:
  // sender: of the datagram. One that was applied before is left out.
  void add(std::uint64_t sender, const ObjectShape& shape);
  void add(std::uint64_t sender, const ShapeStart& start);

  // Begins the motion of that serial in the step, as the haptics node did. False: the recording lacks a part of it or its start, or it is
  // not of that scene; or the step is not where the node was. Pre: called with one serial after the other.
  bool apply(std::uint64_t sender, std::uint32_t serial, HapticsStep& step,
             const std::function<std::shared_ptr<const ProgramShape>(std::int32_t object)>& find_shape);

 private:
  struct Sender {
    std::map<std::uint32_t, ShapeParts> shapes = {};  // by serial
    std::map<std::uint32_t, ShapeStart> starts = {};
    std::uint32_t applied = 0;  // all up to this serial
  };
  std::map<std::uint64_t, Sender> senders_;
};

}  // namespace hapton
