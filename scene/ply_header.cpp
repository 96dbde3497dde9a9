#include "scene/ply_header.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "scene/text_cursor.h"

namespace hapton {
namespace {

std::optional<PlyType> parse_ply_type(std::string_view word) {
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

template <class... Args>
Error at_header_line(std::size_t line, fmt::format_string<Args...> format, Args&&... args) {
  return {fmt::format("line {}: {}", line, fmt::format(format, std::forward<Args>(args)...))};
}

class PlyHeaderReader {
 public:
  explicit PlyHeaderReader(std::string_view bytes) : size_(bytes.size()), cursor_(bytes) {}

  Result<PlyHeader> read() {
    if (cursor_.word_in_line() != "ply") return fail("does not begin with 'ply', so not a PLY file: check its extension");
    for (cursor_.next_line(); !cursor_.at_end(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word_in_line();
      if (keyword == "end_header") return finish();
      if (auto error = read_line(keyword)) return tl::unexpected(std::move(*error));
    }
    return fail("the file ends inside its header, before 'end_header': cut short; copy or export it again");
  }

 private:
  Result<PlyHeader> finish() {
    cursor_.next_line();
    header_.body_offset = size_ - cursor_.bytes_left();
    header_.body_line = cursor_.line();
    if (!has_format_) return fail("the header has no 'format' line: export the file again");
    return std::move(header_);
  }

  std::optional<Error> read_line(std::string_view keyword) {
    if (keyword == "comment" && cursor_.word_in_line() == "TextureFile") header_.textures.emplace_back(cursor_.rest_of_line());
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return std::nullopt;
    if (keyword == "format") return read_format();
    if (keyword == "element") return read_element();
    if (keyword == "property") return read_property();
    return at_header_line(cursor_.line(), "'{}' is not a PLY header keyword: export the file again", printable(keyword));
  }

  std::optional<Error> read_format() {
    const std::string_view word = cursor_.word_in_line();
    has_format_ = true;
    if (word == "ascii")
      header_.encoding = PlyEncoding::ascii;
    else if (word == "binary_little_endian")
      header_.encoding = PlyEncoding::little_endian;
    else if (word == "binary_big_endian")
      header_.encoding = PlyEncoding::big_endian;
    else
      return at_header_line(cursor_.line(), "unknown format '{}': export as ascii or binary_little_endian", printable(word));
    return std::nullopt;
  }

  std::optional<Error> read_element() {
    PlyElement element;
    element.name = std::string(cursor_.word_in_line());
    const std::string_view word = cursor_.word_in_line();
    std::int64_t count = 0;
    if (!parse_integer(word, count) || count < 0) {
      return at_header_line(cursor_.line(), "'{}' is not a number of elements: export the file again", printable(word));
    }
    element.count = static_cast<std::size_t>(count);
    header_.elements.push_back(std::move(element));
    return std::nullopt;
  }

  std::optional<Error> read_property() {
    if (header_.elements.empty()) return at_header_line(cursor_.line(), "a property before any element: export the file again");
    PlyProperty property;
    std::string_view type = cursor_.word_in_line();
    if (type == "list") {
      const std::string_view count_type = cursor_.word_in_line();
      property.list_count = parse_ply_type(count_type);
      if (!property.list_count || *property.list_count == PlyType::f32 || *property.list_count == PlyType::f64) {
        return at_header_line(cursor_.line(), "'{}' is not a type for a list's length: export the file again", printable(count_type));
      }
      type = cursor_.word_in_line();
    }
    const std::optional<PlyType> parsed = parse_ply_type(type);
    if (!parsed) return at_header_line(cursor_.line(), "unknown property type '{}': export the file again", printable(type));
    property.type = *parsed;
    property.name = std::string(cursor_.word_in_line());
    header_.elements.back().properties.push_back(std::move(property));
    return std::nullopt;
  }

  std::size_t size_;
  TextCursor cursor_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

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

Result<PlyHeader> read_ply_header(std::string_view bytes) { return PlyHeaderReader(bytes).read(); }

}  // namespace hapton
