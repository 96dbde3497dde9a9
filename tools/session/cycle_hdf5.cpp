#include <hdf5.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "recording/recording_shape_collector.h"
#include "runtime/part_file.h"
#include "scene/scene_loading.h"
#include "tools/session/csv_names.h"
#include "tools/session/cycle_files.h"

namespace hapton {
namespace {

constexpr hsize_t kBlockRows = 4096;   // rows that are written at once; also the size of a chunk of the file
constexpr unsigned kDeflateLevel = 4;  // level of compression, 1 to 9; a free choice

// Owns an object of HDF5, and closes it in the destructor.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  // Closes the object. False: what HDF5 still had to write on closing was not written.
  bool close_object() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }
  operator hid_t() const { return id_; }
  bool is_good() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

// The HDF5 type of a text in UTF-8 of variable length.
Handle make_text_type() {
  Handle type(H5Tcopy(H5T_C_S1), &H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

bool set_text(hid_t object, const std::string& name, const std::string& value) {
  const Handle type = make_text_type();
  const Handle space(H5Screate(H5S_SCALAR), &H5Sclose);
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), &H5Aclose);
  const char* text = value.c_str();
  return attribute.is_good() && H5Awrite(attribute, type, &text) >= 0;
}

// A table column that grows by blocks.
class Column {
 public:
  Column(hid_t group, const std::string& name, hid_t type, hid_t memory_type) : memory_type_(memory_type) {
    const hsize_t none = 0;
    const hsize_t max_size = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(1, &none, &max_size), &H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
    H5Pset_chunk(properties, 1, &kBlockRows);
    H5Pset_shuffle(properties);
    H5Pset_deflate(properties, kDeflateLevel);
    dataset_ = Handle(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), &H5Dclose);
  }
  bool append(const void* values, hsize_t count) {
    const hsize_t begin = rows_;
    rows_ += count;
    if (!dataset_.is_good() || H5Dset_extent(dataset_, &rows_) < 0) return false;
    const Handle file_space(H5Dget_space(dataset_), &H5Sclose);
    const Handle memory_space(H5Screate_simple(1, &count, nullptr), &H5Sclose);
    return H5Sselect_hyperslab(file_space, H5S_SELECT_SET, &begin, nullptr, &count, nullptr) >= 0 &&
           H5Dwrite(dataset_, memory_type_, memory_space, file_space, H5P_DEFAULT, values) >= 0;
  }
  hid_t dataset() const { return dataset_; }

 private:
  Handle dataset_;
  hid_t memory_type_;
  hsize_t rows_ = 0;
};

// The displacements of an object's vertices: one row for each shape.
class ShapeRows {
 public:
  ShapeRows(hid_t group, const std::string& name, std::size_t vertices) : dimensions_{0, vertices, 3} {
    const std::array<hsize_t, 3> max_size = {H5S_UNLIMITED, dimensions_[1], dimensions_[2]};
    const std::array<hsize_t, 3> chunk = {std::max<hsize_t>(1, kBlockRows / vertices), dimensions_[1], dimensions_[2]};
    const Handle space(H5Screate_simple(3, dimensions_.data(), max_size.data()), &H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
    H5Pset_chunk(properties, 3, chunk.data());
    H5Pset_shuffle(properties);
    H5Pset_deflate(properties, kDeflateLevel);
    dataset_ = Handle(H5Dcreate2(group, name.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), &H5Dclose);
  }
  hid_t dataset() const { return dataset_; }
  bool append(std::span<const ShapePart::Displacement> displacements_m) {
    const std::array<hsize_t, 3> begin = {dimensions_[0], 0, 0};
    const std::array<hsize_t, 3> count = {1, dimensions_[1], dimensions_[2]};
    ++dimensions_[0];
    if (!dataset_.is_good() || H5Dset_extent(dataset_, dimensions_.data()) < 0) return false;
    const Handle file_space(H5Dget_space(dataset_), &H5Sclose);
    const Handle memory_space(H5Screate_simple(3, count.data(), nullptr), &H5Sclose);
    return H5Sselect_hyperslab(file_space, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr) >= 0 &&
           H5Dwrite(dataset_, H5T_NATIVE_FLOAT, memory_space, file_space, H5P_DEFAULT, displacements_m.data()) >= 0;
  }

 private:
  std::array<hsize_t, 3> dimensions_;
  Handle dataset_;
};

// The file of write_joined_hdf5 (cycle_files.h). Errors are kept until finish().
class JoinedHdf5 {
 public:
  explicit JoinedHdf5(const std::filesystem::path& path) {
    // Switches off HDF5's own messages on stderr, because this program reports every failure in one line.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), &H5Fclose);
    if (!file_.is_good()) return;
    const Handle samples(H5Gcreate2(file_, "samples", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    for (const CycleColumn& column : cycle_columns()) {
      columns_.emplace_back(samples, std::string(column.name), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE);
      is_good_ = is_good_ && set_text(columns_.back().dataset(), "unit", std::string(column.unit));
    }
    const Handle events(H5Gcreate2(file_, "events", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    event_times_.emplace(events, "t_s", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE);
    is_good_ = is_good_ && set_text(event_times_->dataset(), "unit", "s");
    event_names_.emplace(events, "name", text_type_, text_type_);
    event_kinds_.emplace(events, "kind", text_type_, text_type_);
    event_samples_.emplace(events, "sample", H5T_STD_U64LE, H5T_NATIVE_UINT64);
    is_good_ = is_good_ && set_text(event_samples_->dataset(), "unit", "1");
    values_.resize(columns_.size());
  }

  void add_names(std::span<const ObjectName> names) {
    const Handle objects(H5Gcreate2(file_, "objects", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    Column name(objects, "name", text_type_, text_type_);
    Column material(objects, "material", text_type_, text_type_);
    for (const ObjectName& one : names) {
      const std::string texts[] = {whole_text(one.object), whole_text(one.material)};
      const char* pointers[] = {texts[0].c_str(), texts[1].c_str()};
      is_good_ = is_good_ && name.append(&pointers[0], 1) && material.append(&pointers[1], 1);
    }
  }

  void add_changes(const ObjectChanges& changes) {
    const Handle moves = add_rows("moves", changes.moves(), move_columns());
    Column names(moves, "name", text_type_, text_type_);
    for (const RecordedMove& one : changes.moves()) {
      const std::string text = whole_text(one.move.name.data());
      const char* const name = text.c_str();
      is_good_ = is_good_ && names.append(&name, 1);
    }
    add_rows("carves", changes.carves(), carve_columns());
    add_setups(changes.setups());
  }

  void add_shape(const RecordedShape& shape) {
    if (!shapes_group_.is_good()) shapes_group_ = Handle(H5Gcreate2(file_, "shapes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    if (shape.row) {
      const std::string name = fmt::format("displacements_{}_{}", shape.process, shape.start.object);
      const auto [entry, is_new] = displacements_.try_emplace(name, shapes_group_, name, shape.displacements_m.size());
      if (is_new) is_good_ = is_good_ && set_text(entry->second.dataset(), "unit", "m");
      is_good_ = entry->second.append(shape.displacements_m) && is_good_;
    }
    shapes_.push_back(shape);
    shapes_.back().displacements_m = {};
  }
  void finish_shapes() {
    if (!shapes_.empty()) add_columns(shapes_group_, shapes_, shape_columns());
  }

  bool is_open() const { return file_.is_good(); }

  void describe(const SessionHeader& header) {
    bool is_good = set_text(file_, "schema", "hapton.table/1") && set_text(file_, "build", header.build) &&
                   set_text(file_, "session", fmt::format("{:016x}", header.session)) &&
                   set_text(file_, "start_unix_ns", fmt::format("{}", header.start_unix_ns));
    if (!header.fault.empty()) is_good = is_good && set_text(file_, "fault", header.fault);
    for (const auto& [name, value] : header.settings) is_good = is_good && set_text(file_, "setting " + name, value);
    is_good_ = is_good_ && is_good;
  }

  void add(const CycleRow& row) {
    for (std::size_t i = 0; i < columns_.size(); ++i) values_[i].push_back(cycle_columns()[i].of(row));
    if (values_.front().size() == kBlockRows) write_block();
    for_each_event(row, [&](const CycleEvent& event) {
      const char* const name = event.name.c_str();
      const char* const kind = event.kind.data();
      is_good_ = is_good_ && event_times_->append(&row.sample_t_s, 1) && event_names_->append(&name, 1) && event_kinds_->append(&kind, 1) &&
                 event_samples_->append(&row.sample, 1);
    });
  }

  // Closes the file, which may fail as well. Returns whether everything was written.
  bool finish() {
    write_block();
    is_good_ = is_good_ && H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0;
    columns_.clear();
    displacements_.clear();
    shapes_group_ = {};
    for (auto* column : {&event_times_, &event_names_, &event_kinds_, &event_samples_}) column->reset();
    return file_.close_object() && is_good_;
  }

 private:
  void add_setups(const std::vector<RecordedSetup>& setups) {
    const Handle group(H5Gcreate2(file_, "haptics", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    Column times(group, "t_s", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE);
    is_good_ = is_good_ && set_text(times.dataset(), "unit", "s");
    for (const RecordedSetup& one : setups) is_good_ = is_good_ && times.append(&one.t_s, 1);
    add_texts(group, "scene", setups, [](const HapticsSetup& setup) { return whole_text(setup.scene.data()); });
    add_texts(group, "scene_hash", setups, [](const HapticsSetup& setup) { return fmt::format("{:016x}", setup.scene_hash); });
    add_texts(group, "loading", setups, [](const HapticsSetup& setup) { return describe_loading(setup.scene_loading); });
    add_texts(group, "method", setups, [](const HapticsSetup& setup) { return whole_text(setup.method.data()); });
    add_texts(group, "build", setups, [](const HapticsSetup& setup) { return whole_text(setup.build.data()); });
  }

  template <class Of>
  void add_texts(hid_t group, const char* name, const std::vector<RecordedSetup>& setups, Of&& of) {
    Column column(group, name, text_type_, text_type_);
    for (const RecordedSetup& one : setups) {
      const std::string text = of(one.setup);
      const char* const pointer = text.c_str();
      is_good_ = is_good_ && column.append(&pointer, 1);
    }
  }

  template <class Row>
  Handle add_rows(const char* name, const std::vector<Row>& rows, std::span<const ChangeColumn<Row>> columns) {
    Handle group(H5Gcreate2(file_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), &H5Gclose);
    add_columns(group, rows, columns);
    return group;
  }

  template <class Row>
  void add_columns(hid_t group, const std::vector<Row>& rows, std::span<const ChangeColumn<Row>> columns) {
    for (const ChangeColumn<Row>& column : columns) {
      std::vector<double> values;
      values.reserve(rows.size());
      for (const Row& row : rows) values.push_back(column.of(row));
      Column dataset_column(group, std::string(column.name), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE);
      is_good_ = is_good_ && set_text(dataset_column.dataset(), "unit", std::string(column.unit));
      is_good_ = is_good_ && (values.empty() || dataset_column.append(values.data(), values.size()));
    }
  }

  void write_block() {
    for (std::size_t i = 0; i < columns_.size() && !values_[i].empty(); ++i) {
      is_good_ = columns_[i].append(values_[i].data(), values_[i].size()) && is_good_;
      values_[i].clear();
    }
  }

  Handle file_;
  Handle text_type_ = make_text_type();
  std::vector<Column> columns_;
  std::optional<Column> event_times_;
  std::optional<Column> event_names_;
  std::optional<Column> event_kinds_;
  std::optional<Column> event_samples_;
  std::vector<std::vector<double>> values_;  // of each column: the rows that are not written yet
  Handle shapes_group_;
  std::vector<RecordedShape> shapes_;               // without their displacements
  std::map<std::string, ShapeRows> displacements_;  // by name of the dataset
  bool is_good_ = true;
};

}  // namespace

Result<CycleCounts> write_joined_hdf5(SessionReader& reader, const std::filesystem::path& path, std::span<const ObjectName> names) {
  // If the disk was full, the library keeps what it could not write, and crashes when it tries again at the end of the program. Everything
  // is closed below, so nothing remains for it to do then.
  H5dont_atexit();
  PartPath part(path);  // declared first, so that it is removed after the file is closed
  JoinedHdf5 file(part.part());
  if (!file.is_open())
    return fail("{}: cannot be written as HDF5: check that the folder can be written to and that the disk is not full", path.string());
  file.describe(reader.header());
  file.add_names(names);
  CycleTable table(reader.header().start_ns, [&](const CycleRow& row) { file.add(row); });
  RecordingShapeCollector shapes(reader.header().start_ns);
  const RecordingShapeCollector::Take take = [&](const RecordedShape& shape) { file.add_shape(shape); };
  const ObjectChanges changes =
      add_all(reader, table, [&](const SessionEntry& entry, const Datagram* datagram) { shapes.add(entry, datagram, take); });
  shapes.finish(take);
  file.finish_shapes();
  file.add_changes(changes);
  if (!file.finish()) return fail("{}: could not be written to its end; is the disk full?", path.string());
  if (const auto kept = part.keep(); !kept) return tl::unexpected(kept.error());
  return CycleCounts{table.rows(), table.without_sample(), table.lost(), table.gaps()};
}

}  // namespace hapton
