#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

#include "scene/raw_mesh.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t kHeaderBytes = 84;    // 80 arbitrary bytes, then the triangle count
constexpr std::size_t kTriangleBytes = 50;  // normal, 3 corners, 2 arbitrary bytes

std::uint32_t triangle_count(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

// Keywords may be in upper or lower case.
bool is(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(), [](char a, char b) { return (a | 0x20) == b; });
}

// Many binary files begin with "solid" too, so the size decides first; text has no zero bytes.
bool looks_binary(std::string_view bytes) {
  if (bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + kTriangleBytes * std::size_t{triangle_count(bytes)}) return true;
  return !is(TextCursor(without_byte_order_mark(bytes)).word(), "solid") || bytes.find('\0') != std::string_view::npos;
}

Result<RawMesh> read_binary(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes) {
    return fail("has {} bytes, fewer than the {} of a binary STL header: copy or export it again", bytes.size(), kHeaderBytes);
  }
  const std::size_t count = triangle_count(bytes);
  const std::size_t needed = kHeaderBytes + kTriangleBytes * count;
  if (needed > bytes.size()) {
    return fail(
        "the header promises {} triangles ({} bytes) but the file has {} bytes: cut short, or not an STL file; copy or export it again",
        count, needed, bytes.size());
  }
  RawMesh raw;
  raw.format = "binary STL";
  if (needed < bytes.size()) raw.notes.push_back(fmt::format("{} bytes after the last triangle were skipped", bytes.size() - needed));
  raw.begin_part("");
  raw.mesh.vertices.reserve(3 * count);
  raw.mesh.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    std::array<float, 9> corners = {};
    std::memcpy(corners.data(), bytes.data() + kHeaderBytes + kTriangleBytes * t + 12, sizeof corners);
    for (int k = 0; k < 3; ++k) {
      const Vec3 vertex(corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]);
      if (!vertex.allFinite()) return fail("triangle {}: a coordinate is not finite: repair the mesh", t + 1);
      raw.mesh.vertices.push_back(vertex);
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    raw.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  raw.end_parts();
  return raw;
}

class AsciiStlReader {
 public:
  explicit AsciiStlReader(std::string_view text) : cursor_(text) { raw_.format = "ASCII STL"; }

  Result<RawMesh> read() {
    for (std::string_view word = cursor_.word(); !word.empty(); word = cursor_.word()) {
      if (!is(word, "solid")) return tl::unexpected(unexpected_word(word, "solid"));
      raw_.begin_part(std::string(cursor_.rest_of_line()));
      if (auto error = read_solid()) return tl::unexpected(std::move(*error));
    }
    raw_.end_parts();
    return std::move(raw_);
  }

 private:
  Error unexpected_word(std::string_view word, std::string_view wanted) const {
    if (word.empty())
      return {fmt::format("line {}: the file ends where '{}' belongs: cut short; copy or export it again", cursor_.line(), wanted)};
    return {fmt::format("line {}: '{}' where '{}' belongs: export the file again", cursor_.line(), printable(word), wanted)};
  }

  std::optional<Error> read_solid() {
    for (;;) {
      const std::string_view word = cursor_.word();
      if (is(word, "endsolid")) {
        cursor_.next_line();
        return std::nullopt;
      }
      if (!is(word, "facet")) return unexpected_word(word, "facet or endsolid");
      if (auto error = read_facet()) return error;
    }
  }

  std::optional<Error> read_facet() {
    // The normal is skipped: exporters often write a wrong one, and the winding gives the same direction.
    if (auto error = expect("normal")) return error;
    for (int k = 0; k < 3; ++k) {
      if (cursor_.word().empty()) return unexpected_word("", "a normal");
    }
    if (auto error = expect("outer")) return error;
    if (auto error = expect("loop")) return error;
    const auto first = static_cast<std::uint32_t>(raw_.mesh.vertices.size());
    for (int k = 0; k < 3; ++k) {
      if (auto error = read_vertex()) return error;
    }
    raw_.mesh.triangles.push_back({first, first + 1, first + 2});
    if (auto error = expect("endloop")) return error;
    return expect("endfacet");
  }

  std::optional<Error> read_vertex() {
    if (auto error = expect("vertex")) return error;
    Vec3 vertex;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = cursor_.word();
      if (!parse_number(word, vertex[axis])) return unexpected_word(word, "a coordinate");
      if (!std::isfinite(vertex[axis])) {
        return Error{fmt::format("line {}: coordinate '{}' is not finite: repair the mesh", cursor_.line(), printable(word))};
      }
    }
    raw_.mesh.vertices.push_back(vertex);
    return std::nullopt;
  }

  std::optional<Error> expect(std::string_view keyword) {
    const std::string_view word = cursor_.word();
    if (is(word, keyword)) return std::nullopt;
    return unexpected_word(word, keyword);
  }

  TextCursor cursor_;
  RawMesh raw_;
};

}  // namespace

Result<RawMesh> read_stl(std::string_view bytes) {
  return looks_binary(bytes) ? read_binary(bytes) : AsciiStlReader(without_byte_order_mark(bytes)).read();
}

}  // namespace hapton
