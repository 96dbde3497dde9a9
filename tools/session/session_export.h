#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/ns_between.h"
#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_entry.h"
#include "runtime/part_file.h"
#include "scene/object_names.h"
#include "tools/session/shape_tables.h"

namespace hapton {

// Writes a recording as three tables: trajectory.csv (in the format that hapton trajectory writes and hapton replay reads), forces.csv and
// cycles.csv; and the files of ShapeTables. Times are in s from the beginning of the recording. Numbers have all their digits. The files
// appear at close(), each complete; if one cannot be written, none appears. RT: no. Threads: one.
class SessionExport {
 public:
  // Makes the folder. names: of the scene's objects, empty where they are not known. Error: one line with the path.
  static Result<SessionExport> open(const std::filesystem::path& folder, std::int64_t start_ns, std::vector<ObjectName> names = {});

  void add(const SessionEntry& entry, const Datagram* datagram);
  // Ends the tables. Error: one line: a table could not be written to its end.
  Result<void> close();

  struct Rows {
    std::uint64_t trajectory = 0;
    std::uint64_t forces = 0;
    std::uint64_t cycles = 0;
  };
  const Rows& rows() const { return rows_; }
  std::uint64_t shapes() const { return shapes_->rows(); }

 private:
  SessionExport() = default;

  void add_cycle(const SessionEntry& entry);
  void add_sample(std::uint64_t sample, std::int64_t time_ns, const Vec3& p_WD, const Quat& q_WT);
  double seconds(std::int64_t time_ns) const { return seconds_between(start_ns_, time_ns); }

  std::vector<ObjectName> names_;
  std::optional<PartFile> trajectory_;
  std::optional<PartFile> forces_;
  std::optional<PartFile> cycles_;
  std::optional<ShapeTables> shapes_;
  std::int64_t start_ns_ = 0;
  std::uint64_t last_sample_ = 0;
  Rows rows_;
};

}  // namespace hapton
