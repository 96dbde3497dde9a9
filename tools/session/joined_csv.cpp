#include <cerrno>
#include <cmath>
#include <cstring>

#include "runtime/atomic_file.h"
#include "tools/session/csv_names.h"
#include "tools/session/joined_files.h"

namespace hapton {
namespace {

// Numbers have all their digits; what is not known stays empty.
std::string line_of(const JoinedRow& row, std::span<const ObjectName> names) {
  std::string line;
  for (const JoinedColumn& column : joined_columns()) {
    const double value = column.of(row);
    if (!std::isnan(value)) line += fmt::format("{}", value);
    line += ',';
  }
  std::string markers;
  for (const std::string& marker : row.markers) markers += (markers.empty() ? "" : "; ") + marker;
  return line + csv_names(names, row.object) + ',' + row.event + ',' + csv_cell(markers) + '\n';
}

}  // namespace

Result<JoinedCounts> write_joined_csv(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_file_for(path, FileReaders::everyone), &std::fclose);
  const auto failed = [&] { return fail("{}: cannot be written: {}", path.string(), std::strerror(errno)); };
  if (!file) return failed();
  std::string header;
  for (const JoinedColumn& column : joined_columns()) header += std::string(column.name) + ",";
  bool is_good = std::fputs((header + "object_name,material,event,marker\n").c_str(), file.get()) >= 0;
  JoinedTable table(reader.header().start_ns,
                    [&](const JoinedRow& row) { is_good = is_good && std::fputs(line_of(row, names).c_str(), file.get()) >= 0; });
  table.add_all(reader);
  is_good = std::fclose(file.release()) == 0 && is_good;
  if (!is_good) return failed();
  return JoinedCounts{table.rows(), table.without_sample(), table.lost(), table.gaps()};
}

}  // namespace hapton
