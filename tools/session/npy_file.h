#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "runtime/part_file.h"

namespace hapton {

// Writes an array of float32 with the three axes row, vertex and coordinate in NumPy's format, version 1.0
// (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html), row by row. The file appears at keep(), complete, or not at
// all. RT: no. Threads: one.
class NpyFile {
 public:
  // vertices: their number in each row. Error: as for PartFile::open.
  static Result<NpyFile> open(const std::filesystem::path& path, std::uint32_t vertices);

  // Adds a row. Pre: it has as many vertices as open() was given.
  void add(std::span<const std::array<float, 3>> row);

  // Ends the writing. Error: one line; nothing of the file is left.
  Result<void> close();
  // Gives the file its name. Pre: close() succeeded.
  Result<void> keep() { return file_.keep(); }

 private:
  NpyFile(PartFile file, std::uint32_t vertices) : file_(std::move(file)), vertices_(vertices) {}
  void write_header();

  PartFile file_;
  std::uint32_t vertices_;
  std::uint64_t rows_ = 0;
};

}  // namespace hapton
