#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_entry.h"
#include "scene/object_names.h"

namespace hapton {

// Writes a recording as three tables: trajectory.csv (what hapton trajectory and replay read), forces.csv and cycles.csv; times in s
// from the beginning of the recording. Numbers have all their digits. RT: no.
class SessionExport {
 public:
  // Makes the folder. names: of the scene's objects, empty where they are not known. Error: one line with the path.
  static Result<SessionExport> open(const std::filesystem::path& folder, std::int64_t start_ns, std::vector<ObjectName> names = {});

  void add(const SessionEntry& entry, const Datagram* datagram);
  // Error: a table could not be written to its end.
  Result<void> close();

  struct Rows {
    std::uint64_t trajectory = 0;
    std::uint64_t forces = 0;
    std::uint64_t cycles = 0;
  };
  const Rows& rows() const { return rows_; }

 private:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  SessionExport() : trajectory_(nullptr, &std::fclose), forces_(nullptr, &std::fclose), cycles_(nullptr, &std::fclose) {}

  void add_cycle(const SessionEntry& entry);
  void add_sample(std::uint64_t sample, std::int64_t time_ns, const Vec3& p_WD, const Quat& q_WT);
  double seconds(std::int64_t time_ns) const { return 1e-9 * static_cast<double>(time_ns - start_ns_); }

  std::filesystem::path folder_;
  std::vector<ObjectName> names_;
  File trajectory_;
  File forces_;
  File cycles_;
  std::int64_t start_ns_ = 0;
  std::uint64_t last_sample_ = 0;
  bool good_ = true;
  Rows rows_;
};

}  // namespace hapton
