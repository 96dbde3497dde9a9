#include <optional>
#include <utility>

#include "runtime/part_file.h"
#include "tools/session/csv_names.h"
#include "tools/session/csv_rows.h"
#include "tools/session/cycle_files.h"
#include "tools/session/shape_tables.h"

namespace hapton {
namespace {

std::string line_of(const CycleRow& row, std::span<const ObjectName> names) {
  std::string markers;
  for (const std::string& marker : row.markers) markers += (markers.empty() ? "" : "; ") + marker;
  return csv_numbers(cycle_columns(), row) + csv_names(names, row.object) + ',' + row.event + ',' + csv_cell(markers) + '\n';
}

// Without rows it makes no file, but leaves no rows in the file of an earlier export. The caller must keep() the returned file.
template <class Row, class Cell>
Result<std::optional<PartFile>> write_rows(const std::filesystem::path& path, const std::vector<Row>& rows,
                                           std::span<const ChangeColumn<Row>> columns, const char* last_column, Cell&& cell) {
  if (rows.empty() && !std::filesystem::exists(path)) return std::optional<PartFile>();
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  add_line(*file, csv_header(columns) + last_column + '\n');
  for (const Row& row : rows) add_line(*file, csv_numbers(columns, row) + cell(row) + '\n');
  if (const auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  return std::optional(std::move(*file));
}

}  // namespace

Result<CycleCounts> write_cycle_csv(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names) {
  auto file = PartFile::open(path);
  if (!file) return tl::unexpected(file.error());
  add_line(*file, csv_header(cycle_columns()) + "object_name,material,event,marker\n");
  CycleTable table(reader.header().start_ns, [&](const CycleRow& row) { add_line(*file, line_of(row, names)); });
  ShapeTables shapes(path.parent_path(), reader.header().start_ns, {names.begin(), names.end()});
  const ObjectChanges changes =
      add_all(reader, table, [&](const SessionEntry& entry, const Datagram* datagram) { shapes.add(entry, datagram); });
  if (const auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  auto move_file = write_rows(path.parent_path() / "moves.csv", changes.moves(), move_columns(), "name",
                              [](const RecordedMove& one) { return csv_cell(whole_text(one.move.name.data())); });
  if (!move_file) return tl::unexpected(move_file.error());
  const auto name_of = [&](const RecordedCarve& one) {
    const auto object = static_cast<std::size_t>(one.carve.object);
    return object < names.size() ? csv_cell(whole_text(names[object].object)) : std::string();
  };
  auto carve_file = write_rows(path.parent_path() / "carves.csv", changes.carves(), carve_columns(), "name", name_of);
  if (!carve_file) return tl::unexpected(carve_file.error());
  if (const auto closed = shapes.close(); !closed) return tl::unexpected(closed.error());
  for (PartFile* table_file :
       {&*file, move_file->has_value() ? &**move_file : nullptr, carve_file->has_value() ? &**carve_file : nullptr}) {
    if (table_file == nullptr) continue;
    if (const auto kept = table_file->keep(); !kept) return tl::unexpected(kept.error());
  }
  if (const auto kept = shapes.keep(); !kept) return tl::unexpected(kept.error());
  return CycleCounts{table.rows(), table.without_sample(), table.lost(), table.gaps()};
}

}  // namespace hapton
