#pragma once

#include <array>
#include <cstdint>

namespace hapton {

// Those messages of link/messages.h that concern objects that programs deform.

// Displacements of some vertices of an object that programs deform (`deformed_by = "program"` in the scene file), from their positions
// at rest: in m of the mesh, before scale and pose, like those of a morph. A shape is sent in parts that begin at multiples of
// kVerticesPerPart.
struct ShapePart {
  static constexpr std::size_t kMaxObjects = 8;          // in a scene
  static constexpr std::uint32_t kVerticesPerPart = 64;  // 768 bytes: a part is one datagram
  static constexpr std::uint32_t kMaxVertices = 10'000;  // a step moves them in 57 us (decision 191)
  static constexpr std::uint32_t kMaxParts = (kMaxVertices + kVerticesPerPart - 1) / kVerticesPerPart;
  using Displacement = std::array<float, 3>;

  std::uint32_t total = 0;  // vertices of the mesh, 1 to kMaxVertices
  std::uint32_t first = 0;  // the first vertex in this part
  std::array<Displacement, kVerticesPerPart> displacements_m = {};

  std::uint32_t number() const { return first / kVerticesPerPart; }
  std::uint32_t count() const { return first < total ? (total - first < kVerticesPerPart ? total - first : kVerticesPerPart) : 0; }
  static std::uint32_t count_parts(std::uint32_t total) { return (total + kVerticesPerPart - 1) / kVerticesPerPart; }
};

// The same type as HapticsSetup::Text.
using ShapeText = std::array<char, 256>;

// tool or vision -> hub -> haptics: a part of the next shape of an object that programs deform. A shape takes effect once it is whole; it
// is left out if a newer one becomes whole before, or two newer ones begin.
struct ShapeRequest {
  static constexpr double kMaxSeconds = 86'400.0;  // a day

  std::uint32_t stream = 0;  // number of the sender, random, never 0
  std::uint32_t shape = 0;   // counts the sender's shapes, from 1
  ShapeText object = {};     // name; empty: `number` says which object it is
  std::int32_t number = 0;   // the object's number in the scene, from 0
  double over_s = 0.0;       // least time of the motion to this shape, up to kMaxSeconds
  ShapePart part = {};
};

// haptics -> hub -> the sender of a ShapeRequest: what became of that shape. There is no reply for a shape that a newer one replaced.
struct ShapeReply {
  std::uint32_t stream = 0;
  std::uint32_t shape = 0;
  ShapeText rejection = {};  // why the object does not take the shape; empty: it does
  std::int32_t object = 0;   // its number in the scene
  double over_s = 0.0;       // time of the motion; more than requested: slowed to the largest speed of a surface
  std::uint32_t serial = 0;  // serial of its ShapeStart
};

// haptics -> hub -> every vision node: a part of a shape, sent before the ShapeStart of that serial, and again on request.
struct ObjectShape {
  std::uint32_t source = 0;  // number of the haptics process, random, never 0
  std::uint32_t serial = 0;  // as in ShapeStart, never 0
  std::int32_t object = 0;   // its number in the scene
  ShapePart part = {};
};

// haptics -> hub -> every vision node, when a program deforms an object, and in turn once a second: from start_ns on, all vertices move
// straight and evenly from the shape `before` to the shape `serial`, and stay there from end_ns on.
struct ShapeStart {
  std::uint32_t source = 0;   // as in ObjectShape
  std::uint32_t serial = 0;   // counts the shapes of all objects, from 1; 0: the object is at rest
  std::uint32_t before = 0;   // serial of this object's previous shape; 0: at rest
  std::int32_t object = 0;    // its number in the scene
  std::uint32_t total = 0;    // vertices of its mesh
  std::int64_t start_ns = 0;  // scene time
  std::int64_t end_ns = 0;
};

// vision -> hub -> haptics, and from a hub that records: sent while the newest shape of an object is not whole at the sender; the haptics
// node sends that shape again, from a vertex on. A hub that computes forces sends this for each announced shape that is not whole.
struct ShapeStatus {
  std::uint32_t source = 0;  // as in ObjectShape
  std::uint32_t serial = 0;  // of that shape
  std::int32_t object = 0;   // its number in the scene
  std::uint32_t first = 0;   // the first vertex that is missing
  std::uint32_t count = 0;   // vertices to send from `first` on, a multiple of kVerticesPerPart; 0: all
};

}  // namespace hapton
