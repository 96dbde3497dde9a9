#include <array>
#include <vector>

#include "link/session_reader.h"
#include "python/bindings.h"
#include "session/joined_table.h"

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

py::dict read_session(const std::string& path) {
  Columns columns;
  auto reader = value_or_raise(SessionReader::open(path));
  {
    const py::gil_scoped_release others_run;
    JoinedTable table(reader.header().start_ns, [&](const JoinedRow& row) { columns.add(row); });
    table.add_all(reader);
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
  session["units"] = units;
  session["header"] = describe_header(reader.header());
  session["problem"] = reader.problem();
  return session;
}

}  // namespace

void bind_sessions(py::module_& module) {
  module.def("read_session", &read_session, py::arg("path"),
             "Reads a recording of io_node --record: a dict of arrays, one row for each servo cycle, with the columns of docs/formats.md\n"
             "(t_s, sample, x_m ... lost; not known: NaN), and units and header. event (the faults of a row, or the text of a marker), "
             "event_kind\n"
             "(fault or marker), event_t_s and event_sample are what happened. problem is not empty where the file is\n"
             "truncated or damaged: what could be read is there.");
}

}  // namespace hapton::python
