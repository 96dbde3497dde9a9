#pragma once

#include <array>
#include <cstdint>

namespace hapton {

// The messages about objects that programs deform, of those in link/messages.h.

// Displacements of some vertices of an object that programs deform (`deformed_by = "program"` in the scene file), from where they are at
// rest: m, of the mesh, before scale and pose, as a morph's. A shape is sent in parts that begin at each multiple of kMaxHere.
struct ShapePart {
  static constexpr std::size_t kMaxObjects = 8;          // of a scene
  static constexpr std::uint32_t kMaxHere = 64;          // 768 bytes: a part is one datagram
  static constexpr std::uint32_t kMaxVertices = 10'000;  // a step moves them in 57 us (decision 191)
  static constexpr std::uint32_t kMaxParts = (kMaxVertices + kMaxHere - 1) / kMaxHere;
  using Displacement = std::array<float, 3>;

  std::uint32_t total = 0;  // vertices of the mesh, 1 to kMaxVertices
  std::uint32_t first = 0;  // the first one here
  std::array<Displacement, kMaxHere> displacements_m = {};

  std::uint32_t number() const { return first / kMaxHere; }
  std::uint32_t count() const { return first < total ? (total - first < kMaxHere ? total - first : kMaxHere) : 0; }
  static std::uint32_t count_parts(std::uint32_t total) { return (total + kMaxHere - 1) / kMaxHere; }
};

// As HapticsSetup::Text.
using ShapeText = std::array<char, 256>;

// tool or vision -> hub -> haptics: a part of the next shape of an object that programs deform. A shape counts once it is whole; a part of
// a newer one discards it.
struct ShapeRequest {
  static constexpr double kMaxSeconds = 86'400.0;  // a day

  std::uint32_t stream = 0;  // of the sender, random, never 0
  std::uint32_t shape = 0;   // counts the sender's shapes, from 1
  ShapeText object = {};     // name; empty: the object of that number
  std::int32_t number = 0;   // of the scene, from 0
  double over_s = 0.0;       // that the motion to this shape takes at least, up to kMaxSeconds
  ShapePart part = {};
};

// haptics -> hub -> the sender of a ShapeRequest: what became of that shape. None comes for a shape that a newer one replaced.
struct ShapeReply {
  std::uint32_t stream = 0;
  std::uint32_t shape = 0;
  ShapeText rejection = {};  // why the object does not take the shape; empty: it does
  std::int32_t object = 0;   // of the scene
  double over_s = 0.0;       // more than requested: slowed to the largest speed of a surface
  std::uint32_t serial = 0;  // of its ShapeStart
};

// haptics -> hub -> every vision node, before the ShapeStart of that serial, and again on request.
struct ObjectShape {
  std::uint32_t source = 0;  // of the haptics process, random, never 0
  std::uint32_t serial = 0;  // as in ShapeStart, never 0
  std::int32_t object = 0;   // of the scene
  ShapePart part = {};
};

// haptics -> hub -> every vision node, when a program deforms an object, and in turn once a second: from start_ns on, all vertices move
// straight and evenly from the shape `before` to the shape `serial`, and stay there from end_ns on.
struct ShapeStart {
  std::uint32_t source = 0;   // as in ObjectShape
  std::uint32_t serial = 0;   // counts the shapes of all objects, from 1; 0: it is at rest
  std::uint32_t before = 0;   // serial of this object's shape before; 0: at rest
  std::int32_t object = 0;    // of the scene
  std::uint32_t total = 0;    // vertices of its mesh
  std::int64_t start_ns = 0;  // scene time
  std::int64_t end_ns = 0;
};

// vision -> hub -> haptics, and from a hub that records: while the newest shape of an object is not whole there. It is sent again, from a
// vertex on. From a hub that computes forces: for each announced shape that is not whole.
struct ShapeStatus {
  std::uint32_t source = 0;  // as in ObjectShape
  std::uint32_t serial = 0;  // of that shape
  std::int32_t object = 0;   // of the scene
  std::uint32_t first = 0;   // the first vertex that is missing
  std::uint32_t count = 0;   // of vertices from there on, as parts have them; 0: all
};

}  // namespace hapton
