#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "scene/ply_header.h"
#include "scene/polygon.h"
#include "scene/raw_mesh.h"
#include "scene/read_mtl.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

// Values of an ASCII body. A line end is the same as a blank, as in most readers.
class AsciiValues {
 public:
  AsciiValues(std::string_view body, const PlyHeader& header) : cursor_(body, header.body_line) {}

  // Null: the value was read. Otherwise: why it was not.
  const char* read(PlyType /*type*/, double& value) {
    const std::string_view word = cursor_.word();
    if (word.empty()) return "the file ends too early: cut short; copy or export it again";
    return parse_number(word, value) ? nullptr : "something that is not a number: export the file again";
  }
  std::string place() const { return fmt::format("line {}", cursor_.line()); }
  std::size_t bytes_left() const { return cursor_.bytes_left(); }
  // The number of bytes from the next word to the end. Nothing can be read after this call.
  std::size_t end() {
    const std::size_t word = cursor_.word().size();
    return word == 0 ? 0 : word + cursor_.bytes_left();
  }
  static std::size_t least_bytes(PlyType /*type*/) { return 1; }

 private:
  TextCursor cursor_;
};

class BinaryValues {
 public:
  BinaryValues(std::string_view body, const PlyHeader& header)
      : at_(body.data()), bytes_left_(body.size()), offset_(header.body_offset), swaps_bytes_(header.encoding == PlyEncoding::big_endian) {}

  const char* read(PlyType type, double& value) {
    const std::size_t size = size_of(type);
    if (bytes_left_ < size) return "the file ends too early: cut short; copy or export it again";
    if (swaps_bytes_) {
      std::array<char, 8> raw = {};
      std::reverse_copy(at_, at_ + size, raw.begin());
      value = decode(type, raw.data());
    } else {
      value = decode(type, at_);
    }
    at_ += size;
    bytes_left_ -= size;
    offset_ += size;
    return nullptr;
  }
  std::string place() const { return fmt::format("byte {}", offset_); }
  std::size_t bytes_left() const { return bytes_left_; }
  std::size_t end() const { return bytes_left_; }
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
  std::size_t bytes_left_;
  std::size_t offset_;
  bool swaps_bytes_;
};

static_assert(std::endian::native == std::endian::little, "the byte swap assumes a little-endian machine");

template <class Values>
class BodyReader {
 public:
  BodyReader(const PlyHeader& header, Values values, RawMesh& raw, AppearanceReading appearance, std::size_t max_triangles)
      : header_(header),
        values_(std::move(values)),
        raw_(raw),
        max_triangles_(max_triangles),
        wants_appearance_(appearance != AppearanceReading::off) {}

  std::optional<Error> read() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;
      if (auto error = check_size(element)) return error;
      if (auto error = read_element(element)) return error;
    }
    if (!has_read_faces_) return Error{"the header has no 'face' element with 'vertex_indices': export triangles, not points or strips"};
    return std::nullopt;
  }

  // The number of bytes after the last element. Call once, at the end.
  std::size_t end() { return values_.end(); }
  // Whether the vertices or the faces have texture coordinates.
  bool has_texcoords() const { return has_texcoords_ || has_face_texcoords_; }

 private:
  std::optional<Error> at_place(std::string_view what) const { return Error{fmt::format("{}: {}", values_.place(), what)}; }

  // Checks that the rest of the file can hold as many elements as the header says, before memory is allocated for them.
  std::optional<Error> check_size(const PlyElement& element) const {
    std::size_t least = 0;
    for (const PlyProperty& property : element.properties) least += Values::least_bytes(property.list_count.value_or(property.type));
    if (element.count <= values_.bytes_left() / least) return std::nullopt;
    return Error{fmt::format(
        "the header promises {} of '{}' but the rest of the file, {} bytes, cannot hold them: cut short; copy or export it again",
        element.count, printable(element.name), values_.bytes_left())};
  }

  std::optional<Error> read_element(const PlyElement& element) {
    if (element.name == "vertex") return read_vertices(element);
    if (element.name == "face") return read_faces(element);
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (auto error = skip(property)) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<Error> read_vertices(const PlyElement& element) {
    std::vector<int> axes;
    for (const PlyProperty& property : element.properties) {
      const std::size_t axis = property.list_count ? std::string::npos : std::string("xyz").find(property.name);
      axes.push_back(property.name.size() == 1 && axis != std::string::npos ? static_cast<int>(axis) : -1);
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (std::count(axes.begin(), axes.end(), axis) != 1) {
        return Error{fmt::format("the vertices do not have one property '{}': export the file again", "xyz"[axis])};
      }
    }
    find_normal_axes(element, axes);
    if (wants_appearance_) find_appearance_axes(element, axes);
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
      if (has_colours_ || has_texcoords_) vertex_appearances_.push_back(appearance_of(values));
    }
    return std::nullopt;
  }

  // Normals are read only if all three coordinates are given; these go to places 3 to 5.
  void find_normal_axes(const PlyElement& element, std::vector<int>& axes) {
    std::array<std::vector<std::size_t>, 3> found;
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!property.list_count && property.name == std::string("n") + "xyz"[axis]) found[axis].push_back(p);
      }
    }
    has_normals_ = std::all_of(found.begin(), found.end(), [](const auto& places) { return places.size() == 1; });
    normals_.resize(has_normals_ ? raw_.mesh.vertices.size() : 0, Eigen::Vector3f::Zero());
    for (std::size_t axis = 0; axis < 3 && has_normals_; ++axis) axes[found[axis][0]] = 3 + static_cast<int>(axis);
  }

  // Places of the values of a vertex: position, normal, colour, texture coordinates, alpha.
  static constexpr std::size_t kPlaces = 12;
  static constexpr int kColourPlace = 6;
  static constexpr int kTexcoordPlace = 9;
  static constexpr int kAlphaPlace = 11;

  CornerAppearance appearance_of(const std::array<double, kPlaces>& values) const {
    CornerAppearance appearance;
    for (std::size_t k = 0; k < 3 && has_colours_; ++k) appearance.colour[k] = to_channel(values[kColourPlace + k]);
    if (has_alpha_) appearance.alpha = to_channel(values[kAlphaPlace]);
    if (has_texcoords_) appearance.texcoord = texcoord_of(values[kTexcoordPlace], values[kTexcoordPlace + 1]);
    return appearance;
  }

  std::uint8_t to_channel(double given) const {
    const double channel = given * colour_scale_;
    return static_cast<std::uint8_t>(std::lround(std::isfinite(channel) ? std::clamp(channel, 0.0, 255.0) : 255.0));
  }

  // The factor that scales a colour channel of this type to the range 0 to 255.
  static double scale_of(PlyType type) {
    return type == PlyType::f32 || type == PlyType::f64 ? 255.0 : type == PlyType::u16 ? 1.0 / 257.0 : 1.0;
  }

  // Assigns the places from `place` on to the properties with these names, in this order: to all of them, or (false) to none.
  static bool find_all(const PlyElement& element, std::initializer_list<std::string_view> names, int place, std::vector<int>& axes) {
    std::vector<int> found = axes;
    for (const std::string_view name : names) {
      const auto is_it = [&](const PlyProperty& p) { return !p.list_count && p.name == name; };
      if (std::count_if(element.properties.begin(), element.properties.end(), is_it) != 1) return false;
      const auto at = std::find_if(element.properties.begin(), element.properties.end(), is_it) - element.properties.begin();
      found[static_cast<std::size_t>(at)] = place++;
    }
    axes = found;
    return true;
  }

  // Assigns a place to alpha, if it has the type of the colours, because it is scaled as they are.
  static bool find_alpha(const PlyElement& element, int place, std::vector<int>& axes) {
    const auto type_of = [&](std::string_view name) {
      const auto found = std::find_if(element.properties.begin(), element.properties.end(), [&](const auto& p) { return p.name == name; });
      return found == element.properties.end() ? std::optional<PlyType>() : found->type;
    };
    const auto red = type_of("red") ? type_of("red") : type_of("diffuse_red");
    for (const char* name : {"alpha", "diffuse_alpha"}) {
      if (type_of(name) == red && find_all(element, {name}, place, axes)) return true;
    }
    return false;
  }

  void find_appearance_axes(const PlyElement& element, std::vector<int>& axes) {
    has_colours_ = find_all(element, {"red", "green", "blue"}, kColourPlace, axes) ||
                   find_all(element, {"diffuse_red", "diffuse_green", "diffuse_blue"}, kColourPlace, axes);
    for (std::size_t p = 0; p < axes.size() && has_colours_; ++p) {
      if (axes[p] == kColourPlace) colour_scale_ = scale_of(element.properties[p].type);
    }
    has_alpha_ = has_colours_ && find_alpha(element, kAlphaPlace, axes);
    for (const auto& [u, v] : {std::pair("s", "t"), std::pair("u", "v"), std::pair("texture_u", "texture_v")}) {
      if (raw_.appearance.materials.empty() || has_texcoords_) break;
      has_texcoords_ = find_all(element, {u, v}, kTexcoordPlace, axes);
    }
    vertex_appearances_.resize(has_colours_ || has_texcoords_ ? raw_.mesh.vertices.size() : 0);
  }

  std::optional<Error> read_faces(const PlyElement& element) {
    const auto is_corners = [](const PlyProperty& p) { return p.list_count && (p.name == "vertex_indices" || p.name == "vertex_index"); };
    if (std::count_if(element.properties.begin(), element.properties.end(), is_corners) != 1) {
      return Error{"the faces do not have one list 'vertex_indices': export the file again"};
    }
    has_read_faces_ = true;
    std::vector<int> places(element.properties.size(), -1);
    const auto corners_at = std::find_if(element.properties.begin(), element.properties.end(), is_corners);
    places[static_cast<std::size_t>(corners_at - element.properties.begin())] = kCornersPlace;
    if (wants_appearance_) find_face_places(element, places);
    raw_.mesh.triangles.reserve(raw_.mesh.triangles.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      for (std::size_t p = 0; p < places.size(); ++p) {
        if (auto error = read_of_face(element.properties[p], places[p], i)) return error;
      }
      if (auto error = add_face(i)) return error;
    }
    return std::nullopt;
  }

  // Places of the values of a face: the channels of its colour, the number of its texture, alpha, and two lists.
  static constexpr int kTexturePlace = 3;
  static constexpr int kFaceAlphaPlace = 4;
  static constexpr int kCornersPlace = 5;
  static constexpr int kCornerTexcoordsPlace = 6;

  // Colours and texture coordinates of the vertices take precedence over those of the faces.
  void find_face_places(const PlyElement& element, std::vector<int>& places) {
    has_face_colours_ = !has_colours_ && (find_all(element, {"red", "green", "blue"}, 0, places) ||
                                          find_all(element, {"diffuse_red", "diffuse_green", "diffuse_blue"}, 0, places));
    has_face_alpha_ = has_face_colours_ && find_alpha(element, kFaceAlphaPlace, places);
    for (std::size_t p = 0; p < places.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (has_face_colours_ && places[p] == 0) colour_scale_ = scale_of(property.type);
      if (has_texcoords_ || raw_.appearance.materials.empty()) continue;
      if (property.name == "texcoord" && property.list_count) places[p] = kCornerTexcoordsPlace;
      if (property.name == "texnumber" && !property.list_count) places[p] = kTexturePlace;
    }
    has_face_texcoords_ = std::count(places.begin(), places.end(), kCornerTexcoordsPlace) > 0;
  }

  std::optional<Error> read_of_face(const PlyProperty& property, int place, std::size_t face) {
    if (place == kCornersPlace) return read_corners(property, face);
    if (place == kCornerTexcoordsPlace) return read_list(property, face_texcoords_);
    if (place < 0) return skip(property);
    const char* why = values_.read(property.type, face_values_[static_cast<std::size_t>(place)]);
    return why != nullptr ? at_place(why) : std::nullopt;
  }

  std::optional<Error> read_corners(const PlyProperty& property, std::size_t face) {
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
    return std::nullopt;
  }

  std::optional<Error> add_face(std::size_t face) {
    if (corners_.size() - 2 > max_triangles_ - raw_.mesh.triangles.size()) {
      return at_place(fmt::format("there are more than {} triangles: simplify the mesh", max_triangles_));
    }
    corner_normals_.clear();
    for (std::size_t k = 0; k < corners_.size() && has_normals_; ++k) corner_normals_.push_back(normals_[corners_[k]]);
    const bool has_appearance = !vertex_appearances_.empty() || has_face_colours_ || has_face_texcoords_;
    corner_appearances_.clear();
    for (std::size_t k = 0; k < corners_.size() && has_appearance; ++k) corner_appearances_.push_back(appearance_of_corner(k));
    const PolygonAppearance appearance = {material_of_face(), has_colours_ || has_face_colours_, corner_appearances_};
    if (!raw_.add_polygon(corners_, corner_normals_, has_appearance ? &appearance : nullptr)) {
      return at_place(
          fmt::format("face {} is hollow and has more than {} corners: triangulate it before exporting", face, kMaxPolygonCorners));
    }
    return std::nullopt;
  }

  CornerAppearance appearance_of_corner(std::size_t k) const {
    CornerAppearance appearance = corners_[k] < vertex_appearances_.size() ? vertex_appearances_[corners_[k]] : CornerAppearance();
    for (std::size_t channel = 0; channel < 3 && has_face_colours_; ++channel)
      appearance.colour[channel] = to_channel(face_values_[channel]);
    if (has_face_alpha_) appearance.alpha = to_channel(face_values_[kFaceAlphaPlace]);
    if (has_face_texcoords_ && face_texcoords_.size() == 2 * corners_.size()) {
      appearance.texcoord = texcoord_of(face_texcoords_[2 * k], face_texcoords_[2 * k + 1]);
    }
    return appearance;
  }

  // A face without texture coordinates, or with the number of a texture that the file does not name, has no material.
  std::uint32_t material_of_face() const {
    if (has_texcoords_) return 0;
    const double texture = face_values_[kTexturePlace];
    const bool is_known = texture >= 0.0 && texture < static_cast<double>(raw_.appearance.materials.size());
    if (!has_face_texcoords_ || !is_known || face_texcoords_.size() != 2 * corners_.size()) return TriangleAppearance::kNoMaterial;
    return static_cast<std::uint32_t>(texture);
  }

  std::optional<Error> read_list(const PlyProperty& property, std::vector<double>& list) {
    double count = 0;
    if (const char* why = values_.read(*property.list_count, count)) return at_place(why);
    if (!(count >= 0) || count != std::floor(count)) return at_place("a list's length is not a count: export the file again");
    list.clear();
    for (double k = 0; k < count; ++k) {
      if (const char* why = values_.read(property.type, list.emplace_back())) return at_place(why);
    }
    return std::nullopt;
  }

  std::optional<Error> skip(const PlyProperty& property) {
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

  const PlyHeader& header_;
  Values values_;
  RawMesh& raw_;
  std::size_t max_triangles_;
  std::vector<std::uint32_t> corners_;
  std::vector<Eigen::Vector3f> normals_;  // of the vertices; empty: the file has none
  std::vector<Eigen::Vector3f> corner_normals_;
  bool wants_appearance_;
  std::vector<CornerAppearance> vertex_appearances_;  // of the vertices; empty: the file gives them no appearance
  std::vector<CornerAppearance> corner_appearances_;
  std::vector<double> face_texcoords_;                        // of the present face: two for each corner
  std::array<double, kFaceAlphaPlace + 1> face_values_ = {};  // of the present face
  bool has_alpha_ = false;
  bool has_face_alpha_ = false;
  bool has_face_colours_ = false;
  bool has_face_texcoords_ = false;
  double colour_scale_ = 1.0;
  bool has_colours_ = false;
  bool has_texcoords_ = false;
  bool has_normals_ = false;
  bool has_read_faces_ = false;
};

// PLY does not say what its alpha means: here it is opacity, as in MeshLab. If it is zero everywhere, the program that wrote the file does
// not support alpha.
void blend_by_alpha(RawMesh& raw) {
  std::uint8_t least = 255;
  std::uint8_t most = 0;
  for (const TriangleAppearance& appearance : raw.appearance.triangles) {
    for (const CornerAppearance& corner : appearance.corners) {
      least = std::min(least, corner.alpha);
      most = std::max(most, corner.alpha);
    }
  }
  if (most == 0 && !raw.appearance.triangles.empty()) {
    raw.notes.emplace_back("the alpha of its colours is 0 everywhere, and is left out");
    for (TriangleAppearance& appearance : raw.appearance.triangles) {
      for (CornerAppearance& corner : appearance.corners) corner.alpha = 255;
    }
    return;
  }
  if (least == 255) return;
  for (VisualMaterial& material : raw.appearance.materials) material.alpha_mode = AlphaMode::blend;
  const auto without_image = static_cast<std::uint32_t>(raw.appearance.materials.size());
  raw.appearance.materials.push_back({.name = "", .alpha_mode = AlphaMode::blend});
  for (TriangleAppearance& appearance : raw.appearance.triangles) {
    if (appearance.material == TriangleAppearance::kNoMaterial) appearance.material = without_image;
  }
}

template <class Values>
Result<RawMesh> read_body(const PlyHeader& header, std::string_view body, std::string format, const std::filesystem::path& folder,
                          AppearanceReading appearance, std::size_t max_triangles) {
  RawMesh raw;
  raw.format = std::move(format);
  raw.begin_part("");
  for (std::size_t t = 0; t < header.textures.size() && appearance != AppearanceReading::off; ++t) {
    raw.appearance.materials.push_back({.name = "", .colour = {}, .image = add_image_file(folder / header.textures[t], raw)});
  }
  BodyReader<Values> reader(header, Values(body, header), raw, appearance, max_triangles);
  if (auto error = reader.read()) return tl::unexpected(std::move(*error));
  if (header.encoding == PlyEncoding::ascii && !body.ends_with('\n')) {
    raw.notes.push_back("the last line has no line end: the file may have been cut short");
  }
  if (const std::size_t rest = reader.end(); rest > 0) {
    raw.notes.push_back(fmt::format("{} bytes after the last element were skipped", rest));
  }
  if (!raw.appearance.materials.empty() && !reader.has_texcoords()) {
    raw.notes.push_back("its texture is not drawn: neither its vertices nor its faces have places in it");
  }
  blend_by_alpha(raw);
  raw.end_parts();
  return raw;
}

}  // namespace

Result<RawMesh> read_ply(std::string_view bytes, const std::filesystem::path& folder, AppearanceReading appearance,
                         std::size_t max_triangles) {
  bytes = without_byte_order_mark(bytes);
  const Result<PlyHeader> header = read_ply_header(bytes);
  if (!header) return tl::unexpected(header.error());
  const std::string_view body = bytes.substr(header->body_offset);
  if (header->encoding == PlyEncoding::ascii) return read_body<AsciiValues>(*header, body, "ASCII PLY", folder, appearance, max_triangles);
  return read_body<BinaryValues>(*header, body, "binary PLY", folder, appearance, max_triangles);
}

}  // namespace hapton
