#pragma once

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "runtime/part_file.h"

namespace hapton {

// For tables whose columns have a name and a number of a row, as move_columns() has them. Each is followed by a comma.
template <class Columns>
std::string csv_header(const Columns& columns) {
  std::string header;
  for (const auto& column : columns) header += std::string(column.name) + ",";
  return header;
}

// Numbers have all their digits; what is not known stays empty.
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
