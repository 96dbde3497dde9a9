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

// What a table holds of a recording, and what it lacks.
struct CycleCounts {
  std::uint64_t rows = 0;
  std::uint64_t without_sample = 0;  // cycles of an older recording, which have no row
  std::uint64_t lost = 0;            // samples of the device that are not in the recording
  std::uint64_t gaps = 0;            // the number of runs of consecutive lost samples
};

// Adds a recording, up to its end or the damage, to a table. Returns what was moved and carved in it. on_entry: is called with each entry.
using OnEntry = std::function<void(const SessionEntry& entry, const Datagram* datagram)>;
ObjectChanges add_all(SessionReader& reader, CycleTable& table, const OnEntry& on_entry = {});

// Writes the table of all cycles of a recording up to its end or the damage; reader.problem() says which. names: of the scene's objects,
// empty if they are not known. If programs moved or deformed objects or material was carved, writes moves.csv, carves.csv and shapes.csv
// with its arrays to the same folder. RT: no. Error: one line with the path.
Result<CycleCounts> write_cycle_csv(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

// The same as HDF5: /samples has a dataset for each column of numbers, with the attribute `unit`; /events has `t_s`, `sample`, `kind`
// (fault or marker) and `name`; /objects has `name` and `material` by object number; /moves, /carves and /shapes are as in docs/formats.md;
// /haptics has `t_s`, `scene`, `scene_hash`, `loading`, `method` and `build` of each change of scene or method; the file's attributes
// describe the recording: schema, build, session, start_unix_ns, every setting, and the fault of a flight record.
Result<CycleCounts> write_joined_hdf5(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names = {});

}  // namespace hapton
