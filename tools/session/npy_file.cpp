#include "tools/session/npy_file.h"

#include <fmt/core.h>

#include <bit>
#include <cstdio>
#include <string>

namespace hapton {
namespace {

// The size of the header, which has room for any number of rows; the format requires a multiple of 64.
constexpr std::size_t kNpyHeaderBytes = 128;
static_assert(std::endian::native == std::endian::little, "rows are written as they are in memory");

}  // namespace

Result<NpyFile> NpyFile::open(const std::filesystem::path& path, std::uint32_t vertices) {
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  NpyFile made(std::move(*file), vertices);
  made.write_header();
  return made;
}

void NpyFile::write_header() {
  std::string header = fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}, 3), }}", rows_, vertices_);
  constexpr std::size_t kPreambleBytes = 10;  // bytes before the header's text: magic, version, length
  header.resize(kNpyHeaderBytes - kPreambleBytes - 1, ' ');
  header += '\n';
  const std::string begin = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0, static_cast<char>(header.size()), 0};
  file_.check(std::fwrite((begin + header).data(), 1, kNpyHeaderBytes, file_.get()) == kNpyHeaderBytes);
}

void NpyFile::add(std::span<const std::array<float, 3>> row) {
  ++rows_;
  if (file_.is_good()) file_.check(std::fwrite(row.data(), sizeof row[0], row.size(), file_.get()) == row.size());
}

// Writes the header again, because the number of rows is known only now.
Result<void> NpyFile::close() {
  file_.check(std::fseek(file_.get(), 0, SEEK_SET) == 0);
  if (file_.is_good()) write_header();
  return file_.close();
}

}  // namespace hapton
