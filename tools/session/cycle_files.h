#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "core/base/result.h"
#include "link/session_reader.h"
#include "recording/cycle_table.h"
#include "recording/object_changes.h"
#include "scene/object_names.h"

namespace hapton {

// What was written of a recording.
struct CycleCounts {
  std::uint64_t rows = 0;
  std::uint64_t without_sample = 0;  // cycles of an older recording, which have no row
  std::uint64_t lost = 0;            // samples of the device that are not in the recording
  std::uint64_t gaps = 0;            // the number of gaps that they make
};

// Reads a recording to the end, or to the damage, into a table, and what was moved and carved in it. also: gets each entry, too.
using AlsoAdd = std::function<void(const SessionEntry& entry, const Datagram* datagram)>;
ObjectChanges add_all(SessionReader& reader, CycleTable& table, const AlsoAdd& also = {});

// Writes the joined table of a recording to the end, or to the damage: reader.problem() says which. names: of the scene's objects, empty
// where they are not known. Where anything was moved, carved or deformed by programs, moves.csv, carves.csv and ShapeTables are written
// beside it. RT: no. Error: one line with the path.
Result<CycleCounts> write_cycle_csv(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

// As HDF5: /samples has a dataset for each column of numbers, with the attribute `unit`; /events has `t_s`, `sample`, `kind` (fault or
// marker) and `name`; /objects has `name` and `material` by the number of the object; /moves and /carves have a dataset for each column of
// move_columns() and carve_columns(), and /moves `name`; /haptics has `t_s`, `scene`, `scene_hash`, `loading`, `method` and `build` of each
// change of scene or method; the file's attributes say what the recording is: schema, build, session, start_unix_ns and every setting.
Result<CycleCounts> write_joined_hdf5(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

}  // namespace hapton
