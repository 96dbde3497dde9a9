#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "runtime/part_file.h"
#include "tools/session/csv_names.h"
#include "tools/session/joined_files.h"

namespace hapton {
namespace {

// Numbers have all their digits; what is not known stays empty.
template <class Columns, class Row>
std::string numbers_of(const Columns& columns, const Row& row) {
  std::string line;
  for (const auto& column : columns) {
    const double value = column.of(row);
    if (!std::isnan(value)) line += fmt::format("{}", value);
    line += ',';
  }
  return line;
}

template <class Columns>
std::string header_of(const Columns& columns) {
  std::string header;
  for (const auto& column : columns) header += std::string(column.name) + ",";
  return header;
}

std::string line_of(const JoinedRow& row, std::span<const ObjectName> names) {
  std::string markers;
  for (const std::string& marker : row.markers) markers += (markers.empty() ? "" : "; ") + marker;
  return numbers_of(joined_columns(), row) + csv_names(names, row.object) + ',' + row.event + ',' + csv_cell(markers) + '\n';
}

void add_line(PartFile& file, const std::string& line) { file.check(std::fputs(line.c_str(), file.get()) >= 0); }

// Where there is nothing, there is no file; one of an earlier export becomes empty. To be kept.
template <class Row, class Cell>
Result<std::optional<PartFile>> write_rows(const std::filesystem::path& path, const std::vector<Row>& rows,
                                           std::span<const ChangeColumn<Row>> columns, const char* last, Cell&& cell) {
  if (rows.empty() && !std::filesystem::exists(path)) return std::optional<PartFile>();
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  add_line(*file, header_of(columns) + last + '\n');
  for (const Row& row : rows) add_line(*file, numbers_of(columns, row) + cell(row) + '\n');
  if (const auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  return std::optional(std::move(*file));
}

}  // namespace

Result<JoinedCounts> write_joined_csv(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names) {
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  add_line(*file, header_of(joined_columns()) + "object_name,material,event,marker\n");
  JoinedTable table(reader.header().start_ns, [&](const JoinedRow& row) { add_line(*file, line_of(row, names)); });
  const ObjectChanges changes = add_all(reader, table);
  if (const auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  auto moved = write_rows(path.parent_path() / "moves.csv", changes.moves(), move_columns(), "name",
                          [](const RecordedMove& one) { return csv_cell(one.move.name.data()); });
  if (!moved) return tl::unexpected(moved.error());
  const auto name_of = [&](const RecordedCarve& one) {
    const auto object = static_cast<std::size_t>(one.carve.object);
    return object < names.size() ? csv_cell(names[object].object) : std::string();
  };
  auto carved = write_rows(path.parent_path() / "carves.csv", changes.carves(), carve_columns(), "name", name_of);
  if (!carved) return tl::unexpected(carved.error());
  for (PartFile* table_file : {&*file, moved->has_value() ? &**moved : nullptr, carved->has_value() ? &**carved : nullptr}) {
    if (table_file == nullptr) continue;
    if (const auto kept = table_file->keep(); !kept) return tl::unexpected(kept.error());
  }
  return JoinedCounts{table.rows(), table.without_sample(), table.lost(), table.gaps()};
}

}  // namespace hapton
