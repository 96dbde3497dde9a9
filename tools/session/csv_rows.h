#pragma once

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "runtime/part_file.h"

namespace hapton {

// For tables whose columns have a `name` and a function `of` that returns the number in a row, as in move_columns(). A comma after each.
template <class Columns>
std::string csv_header(const Columns& columns) {
  std::string header;
  for (const auto& column : columns) header += std::string(column.name) + ",";
  return header;
}

// Numbers have as many digits as read back to the same bits; NaN becomes an empty cell.
template <class Columns, class Row>
std::string csv_numbers(const Columns& columns, const Row& row) {
  std::string line;
  for (const auto& column : columns) {
    const double value = column.of(row);
    if (!std::isnan(value)) line += fmt::format("{}", value);
    line += ',';
  }
  return line;
}

inline void add_line(PartFile& file, const std::string& line) { file.check(std::fputs(line.c_str(), file.get()) >= 0); }

}  // namespace hapton
