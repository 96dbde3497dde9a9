#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

// Bytes of a value in a binary body.
std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> list_count;  // set: a list, its length first
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyEncoding { ascii, little_endian, big_endian };

// What a PLY file says of the values that follow.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  // comments of MeshLab and others name them
  std::size_t body_offset = 0;
  std::size_t body_line = 0;
};

// Of a whole file. Error: with the line. RT: set-up only.
Result<PlyHeader> read_ply_header(std::string_view bytes);

}  // namespace hapton
