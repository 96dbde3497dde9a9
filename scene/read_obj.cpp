#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/polygon.h"
#include "scene/raw_mesh.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

// Keywords to skip, because they carry no triangles. Any other unknown keyword becomes a note, so that nothing is dropped silently.
bool is_decoration(std::string_view keyword) {
  for (const std::string_view known :
       {"s", "l", "p", "usemap", "maplib", "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "mg"}) {
    if (keyword == known) return true;
  }
  return false;
}

class ObjReader {
 public:
  ObjReader(std::string_view text, AppearanceReading appearance, std::size_t max_triangles)
      : text_(without_byte_order_mark(text)),
        cursor_(text_),
        wants_appearance_(appearance != AppearanceReading::off),
        max_triangles_(max_triangles) {
    raw_.format = "OBJ";
  }

  Result<RawMesh> read() {
    if (text_.find('\0') != std::string_view::npos) return fail("is not text, so not an OBJ file: check its extension");
    for (; !cursor_.at_end(); cursor_.next_line()) {
      if (auto error = read_line()) return tl::unexpected(std::move(*error));
    }
    add_notes();
    raw_.end_parts();
    return std::move(raw_);
  }

 private:
  template <class... Args>
  Error at_line(fmt::format_string<Args...> format, Args&&... args) const {
    return {fmt::format("line {}: {}", cursor_.line(), fmt::format(format, std::forward<Args>(args)...))};
  }

  std::optional<Error> read_line() {
    const std::string_view keyword = cursor_.word_in_line();
    if (keyword.empty() || keyword[0] == '#' || is_decoration(keyword)) return std::nullopt;
    if (keyword == "v") return read_vertex();
    if (keyword == "vn") {
      read_normal();
      return std::nullopt;
    }
    if (keyword == "f" || keyword == "fo") return read_face();
    if (keyword == "vt" || keyword == "usemtl" || keyword == "mtllib") {
      if (wants_appearance_) read_appearance(keyword);
      return std::nullopt;
    }
    if (keyword == "o" || keyword == "g") {
      (keyword == "o" ? object_ : group_) = std::string(cursor_.rest_of_line());
      if (keyword == "o") group_.clear();
      begin_part();
      return std::nullopt;
    }
    if (unknown_++ == 0) {
      raw_.notes.push_back(at_line("'{}' is not supported; such lines were skipped", printable(keyword)).what);
    }
    return std::nullopt;
  }

  void begin_part() {
    raw_.begin_part(group_.empty() ? object_ : group_);
    if (!group_.empty()) raw_.parts.back().object = object_;
  }

  std::optional<Error> read_vertex() {
    Vec3 vertex;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = cursor_.word_in_line();
      if (word.empty()) return at_line("a vertex has {} coordinates where 3 belong: export the file again", axis);
      if (!parse_number(word, vertex[axis])) {
        return at_line("coordinate '{}' is not a number: export the file again", printable(word));
      }
      if (!std::isfinite(vertex[axis])) return at_line("coordinate '{}' is not finite: repair the mesh", printable(word));
    }
    raw_.mesh.vertices.push_back(vertex);
    if (wants_appearance_) read_colour();
    is_in_face_.push_back(false);
    return std::nullopt;
  }

  // Some programs write red, green and blue after the position. Anything but three numbers is ignored.
  void read_colour() {
    std::array<double, 3> channels = {};
    for (double& channel : channels) {
      if (!parse_number(cursor_.word_in_line(), channel) || !std::isfinite(channel)) return;
    }
    if (!cursor_.word_in_line().empty()) return;
    colours_.resize(raw_.mesh.vertices.size() - 1, CornerAppearance().colour);
    auto& colour = colours_.emplace_back();
    for (int k = 0; k < 3; ++k) colour[k] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(channels[k], 0.0, 1.0)));
  }

  void read_appearance(std::string_view keyword) {
    if (keyword == "vt") {
      double u = 0.0;
      double v = 0.0;
      const bool is_read = parse_number(cursor_.word_in_line(), u) && parse_number(cursor_.word_in_line(), v);
      texcoords_.push_back(is_read ? texcoord_of(u, v) : Eigen::Vector2f(0.0F, 0.0F));
      return;
    }
    const std::string name(cursor_.rest_of_line());
    if (keyword == "mtllib") {
      raw_.mtl_files.push_back(name);
      return;
    }
    const auto [known, is_new] = materials_.emplace(name, static_cast<std::uint32_t>(raw_.appearance.materials.size()));
    if (is_new) raw_.appearance.materials.push_back({.name = name, .colour = {}, .image = {}});
    material_ = known->second;
  }

  // The appearance of a face corner "vertex/texture/normal".
  CornerAppearance appearance_of(std::string_view word, std::uint32_t vertex) const {
    CornerAppearance appearance;
    if (vertex < colours_.size()) appearance.colour = colours_[vertex];
    const auto first = word.find('/');
    if (first == std::string_view::npos) return appearance;
    std::int64_t index = 0;
    if (!parse_integer(word.substr(first + 1, word.find('/', first + 1) - first - 1), index)) return appearance;
    const auto count = static_cast<std::int64_t>(texcoords_.size());
    const std::int64_t from_zero = index < 0 ? count + index : index - 1;
    if (from_zero >= 0 && from_zero < count) appearance.texcoord = texcoords_[static_cast<std::size_t>(from_zero)];
    return appearance;
  }

  // Normals are optional: one that cannot be read counts as missing, and normals are computed for its corners.
  void read_normal() {
    Eigen::Vector3d normal;
    bool is_read = true;
    for (int axis = 0; axis < 3; ++axis) is_read = is_read && parse_number(cursor_.word_in_line(), normal[axis]);
    bad_normals_ += is_read ? 0 : 1;
    normals_.push_back(is_read ? Eigen::Vector3f(normal.cast<float>()) : Eigen::Vector3f(Eigen::Vector3f::Zero()));
  }

  // The normal of a face corner "vertex/texture/normal"; zero: it has none, or its number is wrong.
  Eigen::Vector3f normal_of(std::string_view word) {
    const auto first = word.find('/');
    const auto second = first == std::string_view::npos ? first : word.find('/', first + 1);
    if (second == std::string_view::npos) return Eigen::Vector3f::Zero();
    std::int64_t index = 0;
    const auto count = static_cast<std::int64_t>(normals_.size());
    const bool is_read = parse_integer(word.substr(second + 1), index);
    const std::int64_t from_zero = index < 0 ? count + index : index - 1;
    if (!is_read || index == 0 || from_zero < 0 || from_zero >= count) {
      ++bad_normals_;
      return Eigen::Vector3f::Zero();
    }
    return normals_[static_cast<std::size_t>(from_zero)];
  }

  std::optional<Error> read_face() {
    corners_.clear();
    corner_normals_.clear();
    corner_appearances_.clear();
    const bool has_appearance = material_ != TriangleAppearance::kNoMaterial || !colours_.empty() || !texcoords_.empty();
    for (std::string_view word = cursor_.word_in_line(); !word.empty() && word[0] != '#'; word = cursor_.word_in_line()) {
      std::int64_t index = 0;
      if (!parse_integer(word.substr(0, word.find('/')), index)) {
        return at_line("face corner '{}' is not a vertex number: export the file again", printable(word));
      }
      const auto count = static_cast<std::int64_t>(raw_.mesh.vertices.size());
      const std::int64_t from_zero = index < 0 ? count + index : index - 1;
      if (index == 0 || from_zero < 0 || from_zero >= count) {
        return at_line("vertex number {} is out of range, {} vertices come before: export the file again", index, count);
      }
      corners_.push_back(static_cast<std::uint32_t>(from_zero));
      if (!normals_.empty()) corner_normals_.push_back(normal_of(word));
      if (has_appearance) corner_appearances_.push_back(appearance_of(word, corners_.back()));
    }
    if (corners_.size() < 3) return at_line("a face has {} corners where at least 3 belong: export the file again", corners_.size());
    if (corners_.size() - 2 > max_triangles_ - raw_.mesh.triangles.size()) {
      return at_line("there are more than {} triangles: simplify the mesh", max_triangles_);
    }
    for (const std::uint32_t corner : corners_) is_in_face_[corner] = true;
    const PolygonAppearance appearance = {material_, !colours_.empty(), corner_appearances_};
    if (!raw_.add_polygon(corners_, corner_normals_, has_appearance ? &appearance : nullptr)) {
      return at_line("a hollow polygon has {} corners, more than {}: triangulate it before exporting", corners_.size(), kMaxPolygonCorners);
    }
    if (raw_.parts.empty()) raw_.parts.push_back({});
    return std::nullopt;
  }

  void add_notes() {
    if (unknown_ > 1) raw_.notes.push_back(fmt::format("{} lines in all have keywords that were skipped", unknown_));
    if (bad_normals_ > 0) raw_.notes.push_back(fmt::format("{} vertex normals cannot be read: computed there", bad_normals_));
    // An OBJ file contains no counts, so unused vertices are the only sign that a file was cut at the end of a line.
    const auto loose = std::count(is_in_face_.begin(), is_in_face_.end(), false);
    if (loose > 0) {
      raw_.notes.push_back(fmt::format("{} of {} vertices belong to no face: the file may have been cut short", loose, is_in_face_.size()));
    }
    if (!text_.ends_with('\n')) raw_.notes.push_back("the last line has no line end: the file may have been cut short");
  }

  std::string_view text_;
  TextCursor cursor_;
  bool wants_appearance_;
  std::size_t max_triangles_;
  RawMesh raw_;
  std::vector<std::uint32_t> corners_;
  std::vector<Eigen::Vector3f> normals_;
  std::vector<Eigen::Vector3f> corner_normals_;  // one for each of corners_; empty: the file has no normals
  std::vector<Eigen::Vector2f> texcoords_;
  std::vector<std::array<std::uint8_t, 3>> colours_;  // of the vertices up to the last one that has a colour
  std::vector<CornerAppearance> corner_appearances_;  // one for each of corners_; empty: the file gives no appearance
  std::map<std::string, std::uint32_t> materials_;
  std::uint32_t material_ = TriangleAppearance::kNoMaterial;  // of the faces that follow
  std::vector<bool> is_in_face_;                              // of each vertex
  std::string object_;                                        // object_ and group_: names for the faces that follow
  std::string group_;
  std::size_t unknown_ = 0;
  std::size_t bad_normals_ = 0;
};

}  // namespace

Result<RawMesh> read_obj(std::string_view bytes, AppearanceReading appearance, std::size_t max_triangles) {
  return ObjReader(bytes, appearance, max_triangles).read();
}

}  // namespace hapton
