#include "tests/fuzz/mesh_mutators.h"

#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hapton::fuzz {
namespace {

constexpr std::size_t kStlCountAt = 80;
constexpr std::size_t kStlHeaderBytes = 84;
constexpr std::size_t kStlTriangleBytes = 50;

std::uint32_t load32(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void store32(std::size_t value, std::uint8_t* into) {
  const auto number = static_cast<std::uint32_t>(value);
  std::memcpy(into, &number, sizeof number);
}

// Replaces one number of four bytes, at an offset that is a multiple of four.
void change_float(Bytes& bytes, Mutation& mutation) {
  // 0, -0, infinite, not a number, the smallest and largest, 1, -1, and (about) 1e-20, 2.5e18 and 1e-7.
  constexpr std::uint32_t kOddBits[] = {0,          0x80000000, 0x7F800000, 0xFF800000, 0x7FC00000, 1,
                                        0x7F7FFFFF, 0x3F800000, 0xBF800000, 0x1E3CE508, 0x5E0AC723, 0x33D6BF95};
  const std::uint32_t bits = kOddBits[mutation.below(std::size(kOddBits))];
  std::memcpy(bytes.data() + 4 * mutation.below(bytes.size() / 4), &bits, sizeof bits);
}

Bytes change_plainly(std::span<const std::uint8_t> file, Mutation& mutation) {
  return mutation.change(Bytes(file.begin(), file.end()), mutation.max_size());
}

struct Chunk {
  std::uint32_t kind = 0;
  Bytes bytes;
};

constexpr std::uint32_t kGlbMagic = 0x46546C67;
constexpr std::uint32_t kJson = 0x4E4F534A;
constexpr std::uint32_t kBin = 0x004E4942;

std::optional<std::vector<Chunk>> split_glb(std::span<const std::uint8_t> file) {
  if (file.size() < 12 || load32(file, 0) != kGlbMagic) return std::nullopt;
  std::vector<Chunk> chunks;
  for (auto rest = file.subspan(12); rest.size() >= 8;) {
    const std::size_t length = std::min<std::size_t>(load32(rest, 0), rest.size() - 8);
    const auto bytes = rest.subspan(8, length);
    chunks.push_back({load32(rest, 4), Bytes(bytes.begin(), bytes.end())});
    rest = rest.subspan(8 + length);
  }
  return chunks;
}

Bytes join_glb(std::span<const std::uint8_t> header, std::vector<Chunk>& chunks) {
  Bytes file(header.begin(), header.begin() + 12);
  for (Chunk& chunk : chunks) {
    while (chunk.bytes.size() % 4 != 0) chunk.bytes.push_back(chunk.kind == kJson ? ' ' : 0);
    file.resize(file.size() + 8);
    store32(chunk.bytes.size(), file.data() + file.size() - 8);
    store32(chunk.kind, file.data() + file.size() - 4);
    file.insert(file.end(), chunk.bytes.begin(), chunk.bytes.end());
  }
  store32(file.size(), file.data() + 8);
  return file;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Offset and length of the first whole number at or after `from`; nothing if there is no number.
std::optional<std::pair<std::size_t, std::size_t>> find_number(std::string_view text, std::size_t from) {
  const std::size_t begin = text.find_first_of("0123456789", from);
  if (begin == std::string_view::npos) return std::nullopt;
  std::size_t end = begin;
  while (end < text.size() && is_digit(text[end])) ++end;
  return std::pair(begin, end - begin);
}

void change_json_number(std::string& text, Mutation& mutation) {
  const auto digit_range = find_number(text, mutation.below(text.size() + 1));
  if (!digit_range) return;
  const std::string_view digits = std::string_view(text).substr(digit_range->first, digit_range->second);
  std::uint64_t number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  number = mutation.one_in(2) ? number + mutation.below(9) - 4 : mutation.odd_number();
  text.replace(digit_range->first, digit_range->second, std::to_string(number));
}

// Sets the length that the JSON gives for the first buffer.
void set_buffer_length(std::string& text, std::size_t length) {
  const std::size_t buffers = text.find("\"buffers\"");
  const std::size_t at = text.find("\"byteLength\"", buffers);
  if (buffers == std::string::npos || at == std::string::npos) return;
  if (const auto digit_range = find_number(text, at)) text.replace(digit_range->first, digit_range->second, std::to_string(length));
}

void change_json(Bytes& json, Mutation& mutation) {
  if (mutation.one_in(3)) {
    json = mutation.change(std::move(json), json.size() + 256);
    return;
  }
  std::string text(json.begin(), json.end());
  change_json_number(text, mutation);
  json.assign(text.begin(), text.end());
}

void change_bin(Bytes& bin, Mutation& mutation) {
  if (bin.size() >= 4 && mutation.one_in(2)) return change_float(bin, mutation);
  bin = mutation.change(std::move(bin), bin.size() + 64);
}

void fit_buffer_length(std::vector<Chunk>& chunks) {
  for (Chunk& chunk : chunks) {
    if (chunk.kind != kJson) continue;
    for (const Chunk& bin : chunks) {
      if (bin.kind != kBin) continue;
      std::string text(chunk.bytes.begin(), chunk.bytes.end());
      set_buffer_length(text, bin.bytes.size());
      chunk.bytes.assign(text.begin(), text.end());
      return;
    }
  }
}

}  // namespace

bool has_stl_count(std::span<const std::uint8_t> file) {
  return file.size() >= kStlHeaderBytes && file.size() == kStlHeaderBytes + kStlTriangleBytes * load32(file, kStlCountAt);
}

bool has_glb_lengths(std::span<const std::uint8_t> file) {
  if (file.size() < 12 || load32(file, 0) != kGlbMagic || load32(file, 8) != file.size()) return false;
  auto rest = file.subspan(12);
  while (rest.size() >= 8) {
    const std::size_t length = load32(rest, 0);
    if (length % 4 != 0 || length > rest.size() - 8) return false;
    rest = rest.subspan(8 + length);
  }
  return rest.empty();
}

Bytes mutate_stl(std::span<const std::uint8_t> file, Mutation& mutation) {
  if (!has_stl_count(file) || file.size() == kStlHeaderBytes) return change_plainly(file, mutation);
  const auto header = file.first(kStlHeaderBytes);
  const auto body = file.subspan(kStlHeaderBytes);
  Bytes triangles(body.begin(), body.end());
  if (mutation.one_in(2)) {
    std::span<std::uint8_t> one(triangles.data() + kStlTriangleBytes * mutation.below(triangles.size() / kStlTriangleBytes), 48);
    Bytes numbers(one.begin(), one.end());
    change_float(numbers, mutation);
    std::copy(numbers.begin(), numbers.end(), one.begin());
  } else {
    triangles = mutation.change(std::move(triangles), body.size() + 8 * kStlTriangleBytes);
    triangles.resize(triangles.size() / kStlTriangleBytes * kStlTriangleBytes);
  }
  Bytes changed(header.begin(), header.end());
  store32(triangles.size() / kStlTriangleBytes, changed.data() + kStlCountAt);
  changed.insert(changed.end(), triangles.begin(), triangles.end());
  return changed;
}

Bytes mutate_glb(std::span<const std::uint8_t> file, Mutation& mutation) {
  auto chunks = split_glb(file);
  if (!chunks || chunks->empty()) return change_plainly(file, mutation);
  Chunk& chunk = (*chunks)[mutation.below(chunks->size())];
  if (mutation.one_in(16)) {
    mutation.change_order(*chunks);
    return join_glb(file.first(12), *chunks);
  }
  chunk.kind == kJson ? change_json(chunk.bytes, mutation) : change_bin(chunk.bytes, mutation);
  if (chunk.kind == kBin) fit_buffer_length(*chunks);
  return join_glb(file.first(12), *chunks);
}

}  // namespace hapton::fuzz
