#include <fmt/core.h>

#include <array>
#include <vector>

#include "link/session_reader.h"
#include "python/bindings.h"
#include "scene/scene_loading.h"
#include "session/joined_table.h"
#include "session/object_changes.h"
#include "session/session_entries.h"

namespace hapton::python {
namespace {

// The columns of a recording, filled row by row.
struct Columns {
  std::vector<std::vector<double>> numbers = std::vector<std::vector<double>>(joined_columns().size());
  std::vector<double> event_t_s;
  std::vector<std::string> event_names;
  std::vector<std::string> event_kinds;
  std::vector<std::uint64_t> event_samples;

  void add(const JoinedRow& row) {
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k].push_back(joined_columns()[k].of(row));
    for_each_event(row, [&](const JoinedEvent& event) {
      event_t_s.push_back(row.sample_t_s);
      event_names.push_back(event.name);
      event_kinds.emplace_back(event.kind);
      event_samples.push_back(row.sample);
    });
  }
};

// The vector's memory becomes the array's.
py::array_t<double> give_away(std::vector<double>&& numbers) {
  auto owned = std::make_unique<std::vector<double>>(std::move(numbers));
  const py::capsule owner(owned.get(), [](void* vector) { delete static_cast<std::vector<double>*>(vector); });
  const std::vector<double>& kept = *owned.release();
  return py::array_t<double>(static_cast<py::ssize_t>(kept.size()), kept.data(), owner);
}

// One array for each column.
template <class Row>
py::dict describe_changes(const std::vector<Row>& rows, std::span<const ChangeColumn<Row>> columns) {
  py::dict described;
  for (const ChangeColumn<Row>& column : columns) {
    std::vector<double> numbers;
    numbers.reserve(rows.size());
    for (const Row& row : rows) numbers.push_back(column.of(row));
    described[py::str(column.name.data(), column.name.size())] = give_away(std::move(numbers));
  }
  return described;
}

py::list names_of(const std::vector<RecordedMove>& moves) {
  py::list names;
  for (const RecordedMove& one : moves) names.append(make_text(one.move.name.data()));
  return names;
}

py::dict describe_header(const SessionHeader& header) {
  py::dict settings;
  for (const auto& [name, value] : header.settings) settings[py::str(name)] = value;
  py::dict described;
  described["build"] = header.build;
  described["start_unix_ns"] = header.start_unix_ns;
  described["session"] = header.session;
  described["fault"] = header.fault;
  described["settings"] = settings;
  return described;
}

py::list describe_setups(const std::vector<RecordedSetup>& setups) {
  py::list described;
  for (const RecordedSetup& one : setups) {
    py::dict setup;
    setup["t_s"] = one.t_s;
    setup["scene"] = one.setup.scene.data();
    setup["scene_hash"] = fmt::format("{:016x}", one.setup.scene_hash);
    setup["loading"] = describe_loading(one.setup.scene_loading);
    setup["method"] = one.setup.method.data();
    setup["build"] = one.setup.build.data();
    described.append(setup);
  }
  return described;
}

py::dict read_session(const std::string& path) {
  Columns columns;
  auto reader = value_or_raise(SessionReader::open(path));
  ObjectChanges changes(reader.header().start_ns);
  {
    const py::gil_scoped_release others_run;
    JoinedTable table(reader.header().start_ns, [&](const JoinedRow& row) { columns.add(row); });
    (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
      table.add(entry, datagram);
      changes.add(entry, datagram);
      return {};
    });
    table.finish();
    changes.finish();
  }
  py::dict session;
  py::dict units;
  for (std::size_t k = 0; k < joined_columns().size(); ++k) {
    const py::str name(joined_columns()[k].name.data(), joined_columns()[k].name.size());
    session[name] = give_away(std::move(columns.numbers[k]));
    units[name] = py::str(joined_columns()[k].unit.data(), joined_columns()[k].unit.size());
  }
  session["event_t_s"] = give_away(std::move(columns.event_t_s));
  session["event"] = py::cast(columns.event_names);
  session["event_kind"] = py::cast(columns.event_kinds);
  session["event_sample"] =
      py::array_t<std::uint64_t>(static_cast<py::ssize_t>(columns.event_samples.size()), columns.event_samples.data());
  session["moves"] = describe_changes(changes.moves(), move_columns());
  session["moves"]["name"] = names_of(changes.moves());
  session["carves"] = describe_changes(changes.carves(), carve_columns());
  session["units"] = units;
  session["header"] = describe_header(reader.header());
  session["header"]["haptics"] = describe_setups(changes.setups());
  session["problem"] = reader.problem();
  return session;
}

}  // namespace

void bind_sessions(py::module_& module) {
  module.def(
      "read_session", &read_session, py::arg("path"),
      "Reads a recording of io_node --record: a dict of arrays, one row for each servo cycle, with the columns of docs/formats.md\n"
      "(t_s, sample, x_m ... lost; not known: NaN), and units and header. event (the faults of a row, or the text of a marker), "
      "event_kind\n"
      "(fault or marker), event_t_s and event_sample are what happened. moves and carves: dicts of arrays, what programs moved and the "
      "stylus carved.\n"
      "problem is not empty where the file is\n"
      "truncated or damaged: what could be read is there.");
}

}  // namespace hapton::python
