#include <fmt/core.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "link/session_reader.h"
#include "python/bindings.h"
#include "recording/cycle_table.h"
#include "recording/object_changes.h"
#include "recording/recording_entries.h"
#include "recording/recording_shape_collector.h"
#include "scene/scene_loading.h"

namespace hapton::python {
namespace {

// The columns of a recording, filled row by row.
struct Columns {
  std::vector<std::vector<double>> numbers = std::vector<std::vector<double>>(cycle_columns().size());
  std::vector<double> event_t_s;
  std::vector<std::string> event_names;
  std::vector<std::string> event_kinds;
  std::vector<std::uint64_t> event_samples;

  void add(const CycleRow& row) {
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k].push_back(cycle_columns()[k].of(row));
    for_each_event(row, [&](const CycleEvent& event) {
      event_t_s.push_back(row.sample_t_s);
      event_names.push_back(event.name);
      event_kinds.emplace_back(event.kind);
      event_samples.push_back(row.sample);
    });
  }
};

// The array takes over the vector's memory; the numbers are in row-major order.
template <class Number>
py::array_t<Number> give_away(std::vector<Number>&& numbers, std::vector<py::ssize_t> shape) {
  auto owned = std::make_unique<std::vector<Number>>(std::move(numbers));
  const py::capsule owner(owned.get(), [](void* vector) { delete static_cast<std::vector<Number>*>(vector); });
  const std::vector<Number>& moved_numbers = *owned.release();
  return py::array_t<Number>(std::move(shape), moved_numbers.data(), owner);
}

py::array_t<double> give_away(std::vector<double>&& numbers) {
  const auto count = static_cast<py::ssize_t>(numbers.size());
  return give_away(std::move(numbers), {count});
}

// The shapes that programs gave to objects: a row for each, and on request their vertices, which may need more memory than all else.
class Shapes {
 public:
  Shapes(std::int64_t start_ns, bool has_vertices) : collector_(start_ns), has_vertices_(has_vertices) {}

  void add(const SessionEntry& entry, const Datagram* datagram) { collector_.add(entry, datagram, take_); }
  void finish() { collector_.finish(take_); }
  const std::vector<RecordedShape>& rows() const { return rows_; }
  // A dict: for each key (process, object), an array of the shape (shapes, vertices, 3).
  py::dict give_vertices() {
    py::dict vertices_by_key;
    for (auto& [key, array] : arrays_) {
      const auto vertices = static_cast<py::ssize_t>(array.vertices);
      const auto shapes = static_cast<py::ssize_t>(array.numbers.size()) / (3 * vertices);
      vertices_by_key[py::make_tuple(key.first, key.second)] = give_away(std::move(array.numbers), {shapes, vertices, 3});
    }
    return vertices_by_key;
  }

 private:
  struct Array {
    std::size_t vertices = 0;
    std::vector<float> numbers;
  };

  void take(const RecordedShape& shape) {
    rows_.push_back(shape);
    if (!has_vertices_) rows_.back().row.reset();
    if (rows_.back().row) keep(shape);
    rows_.back().displacements_m = {};
  }
  void keep(const RecordedShape& shape) {
    Array& array = arrays_[{shape.process, shape.start.object}];
    array.vertices = shape.displacements_m.size();
    for (const ShapePart::Displacement& one : shape.displacements_m) array.numbers.insert(array.numbers.end(), one.begin(), one.end());
  }

  RecordingShapeCollector collector_;
  bool has_vertices_;
  std::vector<RecordedShape> rows_;
  std::map<std::pair<std::uint32_t, std::int32_t>, Array> arrays_;  // key: process and object
  const RecordingShapeCollector::Take take_ = [this](const RecordedShape& shape) { take(shape); };
};

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
    setup["scene"] = make_text(one.setup.scene.data());
    setup["scene_hash"] = fmt::format("{:016x}", one.setup.scene_hash);
    setup["loading"] = describe_loading(one.setup.scene_loading);
    setup["method"] = make_text(one.setup.method.data());
    setup["build"] = make_text(one.setup.build.data());
    described.append(setup);
  }
  return described;
}

py::dict read_session(const std::string& path, bool vertices) {
  Columns columns;
  auto reader = value_or_raise(SessionReader::open(path));
  ObjectChanges changes(reader.header().start_ns);
  Shapes shapes(reader.header().start_ns, vertices);
  {
    const py::gil_scoped_release gil_released;
    CycleTable table(reader.header().start_ns, [&](const CycleRow& row) { columns.add(row); });
    (void)for_each_entry(reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
      table.add(entry, datagram);
      changes.add(entry, datagram);
      shapes.add(entry, datagram);
      return {};
    });
    table.finish();
    changes.finish();
    shapes.finish();
  }
  py::dict session;
  py::dict units;
  for (std::size_t k = 0; k < cycle_columns().size(); ++k) {
    const py::str name(cycle_columns()[k].name.data(), cycle_columns()[k].name.size());
    session[name] = give_away(std::move(columns.numbers[k]));
    units[name] = py::str(cycle_columns()[k].unit.data(), cycle_columns()[k].unit.size());
  }
  session["event_t_s"] = give_away(std::move(columns.event_t_s));
  session["event"] = py::cast(columns.event_names);
  session["event_kind"] = py::cast(columns.event_kinds);
  session["event_sample"] =
      py::array_t<std::uint64_t>(static_cast<py::ssize_t>(columns.event_samples.size()), columns.event_samples.data());
  session["moves"] = describe_changes(changes.moves(), move_columns());
  session["moves"]["name"] = names_of(changes.moves());
  session["carves"] = describe_changes(changes.carves(), carve_columns());
  session["shapes"] = describe_changes(shapes.rows(), shape_columns());
  if (vertices) session["shapes"]["displacements_m"] = shapes.give_vertices();
  session["units"] = units;
  session["header"] = describe_header(reader.header());
  session["header"]["haptics"] = describe_setups(changes.setups());
  session["problem"] = reader.problem();
  return session;
}

}  // namespace

void bind_sessions(py::module_& module) {
  module.def(
      "read_session", &read_session, py::arg("path"), py::kw_only(), py::arg("vertices") = false,
      "Reads a recording of io_node --record: a dict of arrays, one row for each servo cycle, with the columns of docs/formats.md\n"
      "(t_s, sample, x_m ... lost; not known: NaN), and units and header. event (the faults of a row, or the text of a marker), "
      "event_kind\n"
      "(fault or marker), event_t_s and event_sample are what happened. moves, carves and shapes: dicts of arrays, what programs moved, "
      "the\n"
      "stylus carved and programs deformed. vertices=True: shapes['displacements_m'] has the vertices of shapes, by (process, object)\n"
      "arrays of (shapes, vertices, 3), m of the mesh; row is the number of a shape there. They may need much memory.\n"
      "problem is not empty where the file is\n"
      "truncated or damaged: what could be read is there.");
}

}  // namespace hapton::python
