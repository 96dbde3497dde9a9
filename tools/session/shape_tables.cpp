#include "tools/session/shape_tables.h"

#include <fmt/core.h>

#include "tools/session/csv_names.h"
#include "tools/session/csv_rows.h"

namespace hapton {

void ShapeTables::add(const SessionEntry& entry, const Datagram* datagram) {
  collector_.add(entry, datagram, [this](const RecordedShape& shape) {
    if (result_) result_ = write(shape);
  });
}

Result<void> ShapeTables::open_table() {
  if (table_) return {};
  auto opened = PartFile::open(folder_ / "shapes.csv");
  if (!opened) return tl::unexpected(opened.error());
  table_.emplace(std::move(*opened));
  add_line(*table_, csv_header(shape_columns()) + "file,name\n");
  return {};
}

namespace {

// One array for each object of each haptics process: another process may have had another scene, with other vertices of the object.
std::string array_name(const RecordedShape& shape) { return fmt::format("shapes_{}_{}.npy", shape.process, shape.start.object); }

}  // namespace

// Pre: the shape has a row.
Result<NpyFile*> ShapeTables::find_file(const RecordedShape& shape) {
  const std::string name = array_name(shape);
  auto found = arrays_.find(name);
  if (found == arrays_.end()) {
    auto opened = NpyFile::open(folder_ / name, shape.start.total);
    if (!opened) return tl::unexpected(opened.error());
    found = arrays_.emplace(name, std::move(*opened)).first;
  }
  return &found->second;
}

Result<void> ShapeTables::write(const RecordedShape& shape) {
  if (auto opened = open_table(); !opened) return opened;
  if (shape.row) {
    auto file = find_file(shape);
    if (!file) return tl::unexpected(file.error());
    (*file)->add(shape.displacements_m);
  }
  const auto object = static_cast<std::size_t>(shape.start.object);
  add_line(*table_, csv_numbers(shape_columns(), shape) + (shape.row ? array_name(shape) : "") + ',' +
                        (object < names_.size() ? csv_cell(whole_text(names_[object].object)) : "") + '\n');
  ++rows_;
  return {};
}

Result<void> ShapeTables::close() {
  collector_.finish([this](const RecordedShape& shape) {
    if (result_) result_ = write(shape);
  });
  if (result_ && !table_ && std::filesystem::exists(folder_ / "shapes.csv")) result_ = open_table();
  for (auto& [name, array] : arrays_) {
    if (auto closed = array.close(); result_) result_ = closed;
  }
  if (table_ && result_) result_ = table_->close();
  return result_;
}

// Keeps the table last, because it names the arrays.
Result<void> ShapeTables::keep() {
  for (auto& [name, array] : arrays_) {
    if (auto kept = array.keep(); !kept) return kept;
  }
  return table_ ? table_->keep() : Result<void>();
}

}  // namespace hapton
