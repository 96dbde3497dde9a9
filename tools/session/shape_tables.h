#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "recording/recording_shape_collector.h"
#include "scene/object_names.h"
#include "tools/session/npy_file.h"

namespace hapton {

// Writes the shapes that programs gave to objects: shapes.csv with a row for each (shape_columns(), then `file` and `name`), and the
// displacements of its vertices as index `row` of a NumPy array, shapes_PROCESS_OBJECT.npy. Without shapes it writes no file, but makes a
// shapes.csv of an earlier export empty but for the header. The files appear at keep(). RT: no. Threads: one.
class ShapeTables {
 public:
  // names: of the scene's objects, empty where they are not known.
  ShapeTables(std::filesystem::path folder, std::int64_t start_ns, std::vector<ObjectName> names)
      : folder_(std::move(folder)), names_(std::move(names)), collector_(start_ns) {}

  void add(const SessionEntry& entry, const Datagram* datagram);
  // Ends the files. Error: one line: a file could not be written to its end; then none appears.
  Result<void> close();
  // Gives the files their names. Pre: close() succeeded.
  Result<void> keep();
  std::uint64_t rows() const noexcept { return rows_; }

 private:
  Result<void> write(const RecordedShape& shape);
  Result<NpyFile*> find_file(const RecordedShape& shape);
  Result<void> open_table();

  std::filesystem::path folder_;
  std::vector<ObjectName> names_;
  RecordingShapeCollector collector_;
  std::optional<PartFile> table_;
  std::map<std::string, NpyFile> arrays_;  // by file name
  std::uint64_t rows_ = 0;
  Result<void> result_;  // the first error
};

}  // namespace hapton
