#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

// The number of bytes of a value in a binary body.
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> list_count;  // the value is a list, and this is the type of its length; none: a single value
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyEncoding { ascii, little_endian, big_endian };

// What the header of a PLY file says about the values after it.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  // names of image files, from comments that MeshLab and other programs write
  std::size_t body_offset = 0;        // where the values begin: byte of the file
  std::size_t body_line = 0;          // ... and line of the file
};

// Reads the header of a PLY file. bytes: the whole file. Error: with the line, if the error is at one. RT: set-up only.
Result<PlyHeader> read_ply_header(std::string_view bytes);

}  // namespace hapton
