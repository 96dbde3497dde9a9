#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "scene/polygon.h"
#include "scene/raw_mesh.h"
#include "scene/read_mtl.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<PlyType> parse_type(std::string_view word) {
  struct Name {
    std::string_view text;
    PlyType type;
  };
  static constexpr std::array<Name, 16> kNames = {{{"char", PlyType::i8},
                                                   {"int8", PlyType::i8},
                                                   {"uchar", PlyType::u8},
                                                   {"uint8", PlyType::u8},
                                                   {"short", PlyType::i16},
                                                   {"int16", PlyType::i16},
                                                   {"ushort", PlyType::u16},
                                                   {"uint16", PlyType::u16},
                                                   {"int", PlyType::i32},
                                                   {"int32", PlyType::i32},
                                                   {"uint", PlyType::u32},
                                                   {"uint32", PlyType::u32},
                                                   {"float", PlyType::f32},
                                                   {"float32", PlyType::f32},
                                                   {"double", PlyType::f64},
                                                   {"float64", PlyType::f64}}};
  const auto* found = std::find_if(kNames.begin(), kNames.end(), [&](const Name& name) { return name.text == word; });
  if (found == kNames.end()) return std::nullopt;
  return found->type;
}

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::i8:
    case PlyType::u8:
      return 1;
    case PlyType::i16:
    case PlyType::u16:
      return 2;
    case PlyType::i32:
    case PlyType::u32:
    case PlyType::f32:
      return 4;
    case PlyType::f64:
      return 8;
  }
  return 1;
}

struct Property {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> list_count;  // set: a list, its length first
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { ascii, little_endian, big_endian };

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::string texture;  // a comment of MeshLab and others names it
  std::size_t body_offset = 0;
  std::size_t body_line = 0;
};

template <class... Args>
Error at_line(std::size_t line, fmt::format_string<Args...> format, Args&&... args) {
  return {fmt::format("line {}: {}", line, fmt::format(format, std::forward<Args>(args)...))};
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string_view bytes) : size_(bytes.size()), cursor_(bytes) {}

  Result<Header> read() {
    if (cursor_.word_in_line() != "ply") return fail("does not begin with 'ply', so not a PLY file: check its extension");
    for (cursor_.next_line(); !cursor_.at_end(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word_in_line();
      if (keyword == "end_header") return finish();
      if (auto error = read_line(keyword)) return tl::unexpected(std::move(*error));
    }
    return fail("the file ends inside its header, before 'end_header': cut short; copy or export it again");
  }

 private:
  Result<Header> finish() {
    cursor_.next_line();
    header_.body_offset = size_ - cursor_.bytes_left();
    header_.body_line = cursor_.line();
    if (!has_format_) return fail("the header has no 'format' line: export the file again");
    return std::move(header_);
  }

  std::optional<Error> read_line(std::string_view keyword) {
    if (keyword == "comment" && cursor_.word_in_line() == "TextureFile") header_.texture = std::string(cursor_.rest_of_line());
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return std::nullopt;
    if (keyword == "format") return read_format();
    if (keyword == "element") return read_element();
    if (keyword == "property") return read_property();
    return at_line(cursor_.line(), "'{}' is not a PLY header keyword: export the file again", printable(keyword));
  }

  std::optional<Error> read_format() {
    const std::string_view word = cursor_.word_in_line();
    has_format_ = true;
    if (word == "ascii")
      header_.encoding = Encoding::ascii;
    else if (word == "binary_little_endian")
      header_.encoding = Encoding::little_endian;
    else if (word == "binary_big_endian")
      header_.encoding = Encoding::big_endian;
    else
      return at_line(cursor_.line(), "unknown format '{}': export as ascii or binary_little_endian", printable(word));
    return std::nullopt;
  }

  std::optional<Error> read_element() {
    Element element;
    element.name = std::string(cursor_.word_in_line());
    const std::string_view word = cursor_.word_in_line();
    std::int64_t count = 0;
    if (!parse_integer(word, count) || count < 0) {
      return at_line(cursor_.line(), "'{}' is not a number of elements: export the file again", printable(word));
    }
    element.count = static_cast<std::size_t>(count);
    header_.elements.push_back(std::move(element));
    return std::nullopt;
  }

  std::optional<Error> read_property() {
    if (header_.elements.empty()) return at_line(cursor_.line(), "a property before any element: export the file again");
    Property property;
    std::string_view type = cursor_.word_in_line();
    if (type == "list") {
      const std::string_view count_type = cursor_.word_in_line();
      property.list_count = parse_type(count_type);
      if (!property.list_count || *property.list_count == PlyType::f32 || *property.list_count == PlyType::f64) {
        return at_line(cursor_.line(), "'{}' is not a type for a list's length: export the file again", printable(count_type));
      }
      type = cursor_.word_in_line();
    }
    const std::optional<PlyType> parsed = parse_type(type);
    if (!parsed) return at_line(cursor_.line(), "unknown property type '{}': export the file again", printable(type));
    property.type = *parsed;
    property.name = std::string(cursor_.word_in_line());
    header_.elements.back().properties.push_back(std::move(property));
    return std::nullopt;
  }

  std::size_t size_;
  TextCursor cursor_;
  Header header_;
  bool has_format_ = false;
};

// Values of an ASCII body. Lines do not matter, as in most readers.
class AsciiValues {
 public:
  AsciiValues(std::string_view body, const Header& header) : cursor_(body, header.body_line) {}

  // Null when it was read, else why not.
  const char* read(PlyType /*type*/, double& value) {
    const std::string_view word = cursor_.word();
    if (word.empty()) return "the file ends too early: cut short; copy or export it again";
    return parse_number(word, value) ? nullptr : "something that is not a number: export the file again";
  }
  std::string place() const { return fmt::format("line {}", cursor_.line()); }
  std::size_t bytes_left() const { return cursor_.bytes_left(); }
  static std::size_t least_bytes(PlyType /*type*/) { return 1; }

 private:
  TextCursor cursor_;
};

class BinaryValues {
 public:
  BinaryValues(std::string_view body, const Header& header)
      : at_(body.data()), left_(body.size()), offset_(header.body_offset), swap_(header.encoding == Encoding::big_endian) {}

  const char* read(PlyType type, double& value) {
    const std::size_t size = size_of(type);
    if (left_ < size) return "the file ends too early: cut short; copy or export it again";
    if (swap_) {
      std::array<char, 8> raw = {};
      std::reverse_copy(at_, at_ + size, raw.begin());
      value = decode(type, raw.data());
    } else {
      value = decode(type, at_);
    }
    at_ += size;
    left_ -= size;
    offset_ += size;
    return nullptr;
  }
  std::string place() const { return fmt::format("byte {}", offset_); }
  std::size_t bytes_left() const { return left_; }
  static std::size_t least_bytes(PlyType type) { return size_of(type); }

 private:
  template <class T>
  static double as(const char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }

  static double decode(PlyType type, const char* raw) {
    switch (type) {
      case PlyType::i8:
        return as<std::int8_t>(raw);
      case PlyType::u8:
        return as<std::uint8_t>(raw);
      case PlyType::i16:
        return as<std::int16_t>(raw);
      case PlyType::u16:
        return as<std::uint16_t>(raw);
      case PlyType::i32:
        return as<std::int32_t>(raw);
      case PlyType::u32:
        return as<std::uint32_t>(raw);
      case PlyType::f32:
        return as<float>(raw);
      case PlyType::f64:
        return as<double>(raw);
    }
    return 0.0;
  }

  const char* at_;
  std::size_t left_;
  std::size_t offset_;
  bool swap_;
};

static_assert(std::endian::native == std::endian::little, "the byte swap assumes a little-endian machine");

template <class Values>
class BodyReader {
 public:
  BodyReader(const Header& header, Values values, RawMesh& raw, LookReading look)
      : header_(header), values_(std::move(values)), raw_(raw), wants_look_(look != LookReading::off) {}

  std::optional<Error> read() {
    for (const Element& element : header_.elements) {
      if (element.properties.empty()) continue;
      if (auto error = check_size(element)) return error;
      if (auto error = read_element(element)) return error;
    }
    if (!seen_faces_) return Error{"the header has no 'face' element with 'vertex_indices': export triangles, not points or strips"};
    return std::nullopt;
  }

  std::size_t bytes_left() const { return values_.bytes_left(); }

 private:
  std::optional<Error> at_place(std::string_view what) const { return Error{fmt::format("{}: {}", values_.place(), what)}; }

  // The header's count against the bytes there are, before anything is allocated for it.
  std::optional<Error> check_size(const Element& element) const {
    std::size_t least = 0;
    for (const Property& property : element.properties) least += Values::least_bytes(property.list_count.value_or(property.type));
    if (element.count <= values_.bytes_left() / least) return std::nullopt;
    return Error{fmt::format(
        "the header promises {} of '{}' but the rest of the file, {} bytes, cannot hold them: cut short; copy or export it again",
        element.count, printable(element.name), values_.bytes_left())};
  }

  std::optional<Error> read_element(const Element& element) {
    if (element.name == "vertex") return read_vertices(element);
    if (element.name == "face") return read_faces(element);
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        if (auto error = skip(property)) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<Error> read_vertices(const Element& element) {
    std::vector<int> axes;
    for (const Property& property : element.properties) {
      const std::size_t axis = property.list_count ? std::string::npos : std::string("xyz").find(property.name);
      axes.push_back(property.name.size() == 1 && axis != std::string::npos ? static_cast<int>(axis) : -1);
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (std::count(axes.begin(), axes.end(), axis) != 1) {
        return Error{fmt::format("the vertices do not have one property '{}': export the file again", "xyz"[axis])};
      }
    }
    find_normal_axes(element, axes);
    if (wants_look_) find_look_axes(element, axes);
    raw_.mesh.vertices.reserve(raw_.mesh.vertices.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      std::array<double, kPlaces> values = {};
      for (std::size_t p = 0; p < axes.size(); ++p) {
        if (axes[p] < 0) {
          if (auto error = skip(element.properties[p])) return error;
        } else if (const char* why = values_.read(element.properties[p].type, values[static_cast<std::size_t>(axes[p])])) {
          return at_place(why);
        }
      }
      const Vec3 vertex(values[0], values[1], values[2]);
      if (!vertex.allFinite()) return at_place(fmt::format("vertex {} has a coordinate that is not finite: repair the mesh", i));
      raw_.mesh.vertices.push_back(vertex);
      if (has_normals_) normals_.push_back(Vec3(values[3], values[4], values[5]).cast<float>());
      if (has_colours_ || has_texcoords_) looks_.push_back(look_of(values));
    }
    return std::nullopt;
  }

  // Normals are read when all three coordinates are there: places 3 to 5.
  void find_normal_axes(const Element& element, std::vector<int>& axes) {
    std::array<std::vector<std::size_t>, 3> found;
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const Property& property = element.properties[p];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!property.list_count && property.name == std::string("n") + "xyz"[axis]) found[axis].push_back(p);
      }
    }
    has_normals_ = std::all_of(found.begin(), found.end(), [](const auto& places) { return places.size() == 1; });
    normals_.resize(has_normals_ ? raw_.mesh.vertices.size() : 0, Eigen::Vector3f::Zero());
    for (std::size_t axis = 0; axis < 3 && has_normals_; ++axis) axes[found[axis][0]] = 3 + static_cast<int>(axis);
  }

  // Where each value of a vertex goes: position, normal, colour, place in the texture.
  static constexpr std::size_t kPlaces = 11;
  static constexpr int kColourPlace = 6;
  static constexpr int kTexcoordPlace = 9;

  CornerLook look_of(const std::array<double, kPlaces>& values) const {
    CornerLook look;
    for (std::size_t k = 0; k < 3 && has_colours_; ++k) {
      const double channel = values[kColourPlace + k] * colour_scale_;
      look.colour[k] = static_cast<std::uint8_t>(std::lround(std::isfinite(channel) ? std::clamp(channel, 0.0, 255.0) : 255.0));
    }
    if (has_texcoords_) look.texcoord = texcoord_of(values[kTexcoordPlace], values[kTexcoordPlace + 1]);
    return look;
  }

  // The properties of those names, all of them or none, go to the places from there on.
  static bool find_all(const Element& element, std::initializer_list<std::string_view> names, int place, std::vector<int>& axes) {
    std::vector<int> found = axes;
    for (const std::string_view name : names) {
      const auto is_it = [&](const Property& p) { return !p.list_count && p.name == name; };
      if (std::count_if(element.properties.begin(), element.properties.end(), is_it) != 1) return false;
      const auto at = std::find_if(element.properties.begin(), element.properties.end(), is_it) - element.properties.begin();
      found[static_cast<std::size_t>(at)] = place++;
    }
    axes = found;
    return true;
  }

  void find_look_axes(const Element& element, std::vector<int>& axes) {
    has_colours_ = find_all(element, {"red", "green", "blue"}, kColourPlace, axes) ||
                   find_all(element, {"diffuse_red", "diffuse_green", "diffuse_blue"}, kColourPlace, axes);
    for (std::size_t p = 0; p < axes.size() && has_colours_; ++p) {
      if (axes[p] != kColourPlace) continue;
      const PlyType type = element.properties[p].type;
      colour_scale_ = type == PlyType::f32 || type == PlyType::f64 ? 255.0 : type == PlyType::u16 ? 1.0 / 257.0 : 1.0;
    }
    for (const auto& [u, v] : {std::pair("s", "t"), std::pair("u", "v"), std::pair("texture_u", "texture_v")}) {
      if (raw_.look.materials.empty() || has_texcoords_) break;
      has_texcoords_ = find_all(element, {u, v}, kTexcoordPlace, axes);
    }
    looks_.resize(has_colours_ || has_texcoords_ ? raw_.mesh.vertices.size() : 0);
  }

  std::optional<Error> read_faces(const Element& element) {
    const auto is_corners = [](const Property& p) { return p.list_count && (p.name == "vertex_indices" || p.name == "vertex_index"); };
    if (std::count_if(element.properties.begin(), element.properties.end(), is_corners) != 1) {
      return Error{"the faces do not have one list 'vertex_indices': export the file again"};
    }
    seen_faces_ = true;
    const auto corners_at = std::find_if(element.properties.begin(), element.properties.end(), is_corners);
    raw_.mesh.triangles.reserve(raw_.mesh.triangles.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      for (auto property = element.properties.begin(); property != element.properties.end(); ++property) {
        if (auto error = property == corners_at ? read_face(*property, i) : skip(*property)) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<Error> read_face(const Property& property, std::size_t face) {
    double count = 0;
    if (const char* why = values_.read(*property.list_count, count)) return at_place(why);
    if (!(count >= 3) || count != std::floor(count)) {
      return at_place(fmt::format("face {} has {} corners where at least 3 belong: export the file again", face, count));
    }
    corners_.clear();
    for (double k = 0; k < count; ++k) {
      double index = 0;
      if (const char* why = values_.read(property.type, index)) return at_place(why);
      if (!(index >= 0 && index < static_cast<double>(raw_.mesh.vertices.size())) || index != std::floor(index)) {
        return at_place(fmt::format("face {} names vertex {}, out of range: {} vertices come before; export the file again", face, index,
                                    raw_.mesh.vertices.size()));
      }
      corners_.push_back(static_cast<std::uint32_t>(index));
    }
    corner_normals_.clear();
    for (std::size_t k = 0; k < corners_.size() && has_normals_; ++k) corner_normals_.push_back(normals_[corners_[k]]);
    corner_looks_.clear();
    for (std::size_t k = 0; k < corners_.size() && !looks_.empty(); ++k) {
      corner_looks_.push_back(corners_[k] < looks_.size() ? looks_[corners_[k]] : CornerLook());
    }
    const PolygonLook look = {has_texcoords_ ? 0 : TriangleLook::kNoMaterial, has_colours_, corner_looks_};
    if (!raw_.add_polygon(corners_, corner_normals_, looks_.empty() ? nullptr : &look)) {
      return at_place(
          fmt::format("face {} is hollow and has more than {} corners: triangulate it before exporting", face, kMaxPolygonCorners));
    }
    return std::nullopt;
  }

  std::optional<Error> skip(const Property& property) {
    double value = 0;
    double count = 1;
    if (property.list_count) {
      if (const char* why = values_.read(*property.list_count, count)) return at_place(why);
      if (!(count >= 0) || count != std::floor(count)) return at_place("a list's length is not a count: export the file again");
    }
    for (double k = 0; k < count; ++k) {
      if (const char* why = values_.read(property.type, value)) return at_place(why);
    }
    return std::nullopt;
  }

  const Header& header_;
  Values values_;
  RawMesh& raw_;
  std::vector<std::uint32_t> corners_;
  std::vector<Eigen::Vector3f> normals_;  // of the vertices; empty: the file has none
  std::vector<Eigen::Vector3f> corner_normals_;
  bool wants_look_;
  std::vector<CornerLook> looks_;  // of the vertices; empty: the file says nothing of them
  std::vector<CornerLook> corner_looks_;
  double colour_scale_ = 1.0;
  bool has_colours_ = false;
  bool has_texcoords_ = false;
  bool has_normals_ = false;
  bool seen_faces_ = false;
};

template <class Values>
Result<RawMesh> read_body(const Header& header, std::string_view body, std::string format, const std::filesystem::path& folder,
                          LookReading look) {
  RawMesh raw;
  raw.format = std::move(format);
  raw.begin_part("");
  if (look != LookReading::off && !header.texture.empty()) {
    raw.look.materials.push_back({.name = "", .colour = {}, .image = add_image_file(folder / header.texture, raw)});
  }
  BodyReader<Values> reader(header, Values(body, header), raw, look);
  if (auto error = reader.read()) return tl::unexpected(std::move(*error));
  if (header.encoding == Encoding::ascii) {
    if (!body.ends_with('\n')) raw.notes.push_back("the last line has no line end: the file may have been cut short");
  } else if (reader.bytes_left() > 0) {
    raw.notes.push_back(fmt::format("{} bytes after the last element were skipped", reader.bytes_left()));
  }
  raw.end_parts();
  return raw;
}

}  // namespace

Result<RawMesh> read_ply(std::string_view bytes, const std::filesystem::path& folder, LookReading look) {
  const Result<Header> header = HeaderReader(bytes).read();
  if (!header) return tl::unexpected(header.error());
  const std::string_view body = bytes.substr(header->body_offset);
  if (header->encoding == Encoding::ascii) return read_body<AsciiValues>(*header, body, "ASCII PLY", folder, look);
  return read_body<BinaryValues>(*header, body, "binary PLY", folder, look);
}

}  // namespace hapton
