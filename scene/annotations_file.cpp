#include "scene/annotations_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/valid_utf8.h"
#include "scene/file_bytes.h"
#include "scene/table_reader.h"

namespace hapton {
namespace {

constexpr std::string_view kSchema = "hapton.annotations/1";
// A million carves are about 100 MB.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
constexpr double kFarthestM = 1e6;
constexpr double kMaxCarveM = 1000.0;  // largest radius and length, as in messages
constexpr std::size_t kMaxObjects = 1'000'000;
// Largest deviation of a quaternion's length from 1: files are written with all digits, but a person may type only three.
constexpr double kUnitSlack = 1e-3;

// A text in quotes: a quote, a backslash or a control character is escaped.
std::string quote(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

// The shortest text that reads back to the same number of single precision.
std::string float_text(double value) {
  std::string text = fmt::format("{}", static_cast<float>(value));
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

void write_press(std::string& text, const CarvedPress& press) {
  text += fmt::format("\n[[carve]]\nobject = {}\nradius_m = {}\ncapsules_m = [", press.object, float_text(press.radius_m));
  for (const Carve& carve : press.carves) {
    text += fmt::format("\n  [{}, {}, {}, {}, {}, {}],", float_text(carve.from_m.x()), float_text(carve.from_m.y()),
                        float_text(carve.from_m.z()), float_text(carve.to_m.x()), float_text(carve.to_m.y()), float_text(carve.to_m.z()));
  }
  text += "\n]\n";
}

// A number with all its digits, and with a point or an exponent, so that TOML does not read it as an integer.
std::string number_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string point_text(const Vec3& p) { return fmt::format("[{}, {}, {}]", number_text(p.x()), number_text(p.y()), number_text(p.z())); }

void write_entry(std::string& text, const Stroke& stroke) {
  text += fmt::format("\n[[stroke]]\nobject = {}\npoints_m = [\n", stroke.object);
  for (const Vec3& p : stroke.points_m) text += fmt::format("  {},\n", point_text(p));
  text += "]\n";
}

void write_entry(std::string& text, const Measure& measure) {
  const auto& [from, to] = measure.ends;
  text += fmt::format("\n[[measure]]\nobjects = [{}, {}]\npoints_m = [{}, {}]\n", from.object, to.object, point_text(from.p_O),
                      point_text(to.p_O));
}

// Maps the numbers of objects in the file to those in the scene. Objects that the scene does not have get the numbers after its own.
class ObjectNumbers {
 public:
  ObjectNumbers(std::span<const std::string> names, Annotations& annotations) : scene_count_(names.size()), annotations_(annotations) {
    annotations_.objects.assign(names.begin(), names.end());
    for (std::size_t i = 0; i < names.size(); ++i) by_name_[to_valid_utf8(names[i])].push_back(static_cast<std::int32_t>(i));
  }

  void add(const std::string& name) {
    std::size_t& before = name_counts_[name];
    const auto found = by_name_.find(name);
    if (found != by_name_.end() && before < found->second.size()) {
      numbers_.push_back(found->second[before]);
    } else {
      numbers_.push_back(static_cast<std::int32_t>(annotations_.objects.size()));
      annotations_.objects.push_back(name);
    }
    ++before;
  }

  std::size_t count() const { return numbers_.size(); }
  std::int32_t operator[](std::size_t in_file) const { return numbers_[in_file]; }
  bool is_of_scene(std::int32_t object) const { return static_cast<std::size_t>(object) < scene_count_; }

 private:
  std::size_t scene_count_;
  Annotations& annotations_;
  std::map<std::string, std::vector<std::int32_t>> by_name_;
  std::map<std::string, std::size_t> name_counts_;
  std::vector<std::int32_t> numbers_;
};

// Reads the tables of the file, and ends at the first error.
class AnnotationsParser {
 public:
  AnnotationsParser(const toml::table& table, std::span<const std::string> names) : table_(table), objects_(names, result_.annotations) {}

  Result<AnnotationsRead> parse(std::uint64_t scene_hash) {
    read_head(scene_hash);
    for_each("stroke", [this](const toml::table& each) { read_stroke(each); });
    for_each("measure", [this](const toml::table& each) { read_measure(each); });
    for_each("pose", [this](const toml::table& each) { read_pose(each); });
    for_each("carve", [this](const toml::table& each) { read_carve(each); });
    if (error_) return tl::unexpected(*error_);
    put_in_order();
    return std::move(result_);
  }

 private:
  // Where a table is in the file: the tables are in the order in which things were made, whatever their kinds.
  using Place = std::pair<std::size_t, std::size_t>;
  static Place place_of(const toml::node& node) { return {node.source().begin.line, node.source().begin.column}; }

  void put_in_order() {
    std::vector<std::pair<Place, std::size_t>> order;
    for (std::size_t i = 0; i < entry_places_.size(); ++i) order.emplace_back(entry_places_[i], i);
    std::sort(order.begin(), order.end());
    std::sort(carve_places_.begin(), carve_places_.end());
    Annotations& all = result_.annotations;
    std::vector<Annotation> entries;
    for (const auto& [place, i] : order) {
      entries.push_back(std::move(all.entries[i]));
      const auto before = std::lower_bound(carve_places_.begin(), carve_places_.end(), place) - carve_places_.begin();
      all.carved_before.push_back(static_cast<std::size_t>(before));
    }
    all.entries = std::move(entries);
  }

  template <class... Args>
  void reject(const toml::node& node, fmt::format_string<Args...> format, Args&&... args) {
    if (!error_) error_ = Error{fmt::format("line {}: {}", node.source().begin.line, fmt::format(format, std::forward<Args>(args)...))};
  }

  void keep_error(const TableReader& reader) {
    if (!error_) error_ = reader.error();
  }

  void read_head(std::uint64_t scene_hash) {
    TableReader head(table_, "the file");
    head.allow({"schema", "scene_hash", "objects", "stroke", "measure", "pose", "carve"});
    std::string schema;
    std::string hash;
    head.require("schema");
    head.read("schema", schema);
    head.read("scene_hash", hash);
    if (!head.error() && schema != kSchema) {
      head.fail_at("schema", "the schema is '{}', and this program reads '{}': save the annotations with a program of this version",
                   printable(schema), kSchema);
    }
    keep_error(head);
    if (error_) return;
    result_.is_other_scene = hash != fmt::format("{:016x}", scene_hash);
    const toml::node* names = table_.get("objects");
    if (names == nullptr) return;
    const toml::array* list = names->as_array();
    if (list == nullptr || list->size() > kMaxObjects) return reject(*names, "'objects' must be a list of names, at most {}", kMaxObjects);
    for (const toml::node& name : *list) {
      const auto text = name.value_exact<std::string>();
      if (!text) return reject(name, "'objects' must be a list of names in quotes");
      objects_.add(*text);
    }
  }

  template <class Read>
  void for_each(std::string_view key, Read&& read) {
    const toml::node* node = table_.get(key);
    if (error_ || node == nullptr) return;
    const toml::array* list = node->as_array();
    if (list == nullptr || !list->is_array_of_tables()) return reject(*node, "write [[{}]] tables", key);
    for (const toml::node& each : *list) {
      if (error_) return;
      read(*each.as_table());
    }
  }

  // The number in the scene of the object whose number in the file is `node`.
  std::int32_t find_object(const toml::node& node) {
    const auto given = node.value_exact<std::int64_t>();
    if (!given || *given < 0 || static_cast<std::size_t>(*given) >= objects_.count()) {
      reject(node, "an object is a number in the list 'objects', from 0 to {}", static_cast<std::int64_t>(objects_.count()) - 1);
      return {};  // not used: the file is rejected
    }
    return objects_[static_cast<std::size_t>(*given)];
  }

  double read_coordinate(const toml::node& node) {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (value && std::abs(*value) <= kFarthestM) return *value;
    reject(node, "a coordinate must be a number within {} m", kFarthestM);
    return 0.0;
  }

  Vec3 read_point(const toml::node& node) {
    const toml::array* list = node.as_array();
    Vec3 p = Vec3::Zero();
    if (list == nullptr || list->size() != 3) {
      reject(node, "a point is a list of three numbers, in metres");
      return p;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      p[static_cast<Eigen::Index>(k)] = read_coordinate(*list->get(k));
    }
    return p;
  }

  std::vector<Vec3> read_points(const toml::table& table) {
    const toml::array* list = table.get("points_m")->as_array();
    if (list == nullptr || list->empty()) {
      reject(*table.get("points_m"), "'points_m' must be a list of points");
      return {};
    }
    point_count_ += list->size();
    if (point_count_ > kMaxAnnotationPoints) {
      reject(*table.get("points_m"), "there are more than {} points: split the file", kMaxAnnotationPoints);
      return {};
    }
    std::vector<Vec3> points;
    points.reserve(list->size());
    for (const toml::node& each : *list) {
      if (error_) return {};
      points.push_back(read_point(each));
    }
    return points;
  }

  bool has_keys(const toml::table& table, const std::string& where, std::initializer_list<std::string_view> keys) {
    TableReader reader(table, where);
    reader.allow(keys);
    for (const std::string_view key : keys) reader.require(key);
    keep_error(reader);
    return !error_;
  }

  void add(Annotation entry, bool fits, const toml::table& table) {
    if (error_) return;
    entry_places_.push_back(place_of(table));
    if (!fits) ++result_.left_out;
    result_.annotations.entries.push_back(std::move(entry));
  }

  void read_stroke(const toml::table& table) {
    if (!has_keys(table, "[[stroke]]", {"object", "points_m"})) return;
    Stroke stroke{.object = find_object(*table.get("object")), .points_m = read_points(table)};
    const bool fits = objects_.is_of_scene(stroke.object);
    add(std::move(stroke), fits, table);
  }

  void read_measure(const toml::table& table) {
    if (!has_keys(table, "[[measure]]", {"objects", "points_m"})) return;
    const toml::array* objects = table.get("objects")->as_array();
    const std::vector<Vec3> points = read_points(table);
    if (objects == nullptr || objects->size() != 2 || points.size() != 2) {
      return reject(table, "a measure has two objects and two points");
    }
    Measure measure;
    for (std::size_t i = 0; i < 2; ++i) measure.ends[i] = {find_object(*objects->get(i)), points[i]};
    add(measure, objects_.is_of_scene(measure.ends[0].object) && objects_.is_of_scene(measure.ends[1].object), table);
  }

  void read_pose(const toml::table& table) {
    if (!has_keys(table, "[[pose]]", {"object", "position_m", "rotation"})) return;
    TableReader reader(table, "[[pose]]");
    Vec3 position_m = Vec3::Zero();
    std::array<double, 4> wxyz = {1.0, 0.0, 0.0, 0.0};
    reader.read("position_m", position_m, kFarthestM);
    reader.read("rotation", wxyz, -1.0 - kUnitSlack, 1.0 + kUnitSlack);
    const Quat rotation(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    if (!reader.error() && !(std::abs(rotation.norm() - 1.0) <= kUnitSlack)) {
      reader.fail_at("rotation", "'rotation' must be a unit quaternion [w, x, y, z]");
    }
    keep_error(reader);
    PutDown put_down{.object = find_object(*table.get("object"))};
    if (error_) return;
    put_down.p_m = position_m;
    put_down.q = rotation;
    if (!objects_.is_of_scene(put_down.object)) ++result_.left_out;
    result_.annotations.put_down.push_back(put_down);
  }

  void read_carve(const toml::table& table) {
    if (!has_keys(table, "[[carve]]", {"object", "radius_m", "capsules_m"})) return;
    TableReader reader(table, "[[carve]]");
    CarvedPress press;
    reader.read("radius_m", press.radius_m, 1e-9, kMaxCarveM);
    keep_error(reader);
    press.object = find_object(*table.get("object"));
    press.radius_m = rounded_to_float(press.radius_m);
    const toml::node& capsules = *table.get("capsules_m");
    const toml::array* list = capsules.as_array();
    if (list == nullptr || list->empty()) return reject(capsules, "'capsules_m' must be a list of capsules");
    carve_count_ += list->size();
    if (carve_count_ > kMaxSavedCarves) return reject(capsules, "there are more than {} carves: split the file", kMaxSavedCarves);
    press.carves.reserve(list->size());
    for (const toml::node& each : *list) {
      if (error_) return;
      press.carves.push_back(read_capsule(each, press.radius_m));
    }
    if (error_) return;
    if (!objects_.is_of_scene(press.object)) ++result_.left_out;
    result_.annotations.carved.push_back(std::move(press));
    carve_places_.push_back(place_of(table));
  }

  Carve read_capsule(const toml::node& node, double radius_m) {
    const toml::array* list = node.as_array();
    Carve carve{.radius_m = radius_m};
    if (list == nullptr || list->size() != 6) {
      reject(node, "a capsule is a list of six numbers, in metres: the ball's centre at the beginning and at the end");
      return carve;
    }
    for (std::size_t k = 0; k < 6; ++k) {
      (k < 3 ? carve.from_m : carve.to_m)[static_cast<Eigen::Index>(k % 3)] = rounded_to_float(read_coordinate(*list->get(k)));
    }
    if (!((carve.to_m - carve.from_m).norm() <= kMaxCarveM)) reject(node, "the ends of a capsule are at most {} m apart", kMaxCarveM);
    return carve;
  }

  const toml::table& table_;
  AnnotationsRead result_;
  ObjectNumbers objects_;
  std::size_t point_count_ = 0;
  std::size_t carve_count_ = 0;
  std::vector<Place> entry_places_;
  std::vector<Place> carve_places_;
  std::optional<Error> error_;
};

}  // namespace

std::string AnnotationsRead::describe_misfit() const {
  const std::size_t all = annotations.entries.size() + annotations.put_down.size() + annotations.carved.size();
  if (left_out > 0) {
    return fmt::format("{} of {} entries are on objects that this scene does not have; they stay in the file, and are not shown", left_out,
                       all);
  }
  return is_other_scene && all > 0 ? "they were made with another scene, or another version of it: positions may not match" : "";
}

std::string write_annotations(const Annotations& annotations, std::uint64_t scene_hash) {
  std::string text = fmt::format("schema = \"{}\"\nscene_hash = \"{:016x}\"\nobjects = [", kSchema, scene_hash);
  for (const std::string& name : annotations.objects) text += fmt::format("\n  {},", quote(to_valid_utf8(name)));
  text += annotations.objects.empty() ? "]\n" : "\n]\n";
  std::size_t presses = 0;  // number of presses written so far
  const auto write_presses = [&](std::size_t until) {
    for (; presses < std::min(until, annotations.carved.size()); ++presses) write_press(text, annotations.carved[presses]);
  };
  for (std::size_t i = 0; i < annotations.entries.size(); ++i) {
    if (i < annotations.carved_before.size()) write_presses(annotations.carved_before[i]);
    std::visit([&](const auto& each) { write_entry(text, each); }, annotations.entries[i]);
  }
  write_presses(annotations.carved.size());
  for (const PutDown& pose : annotations.put_down) {
    text += fmt::format("\n[[pose]]\nobject = {}\nposition_m = {}\nrotation = [{}, {}, {}, {}]\n", pose.object, point_text(pose.p_m),
                        number_text(pose.q.w()), number_text(pose.q.x()), number_text(pose.q.y()), number_text(pose.q.z()));
  }
  return text;
}

Result<AnnotationsRead> parse_annotations(std::string_view text, std::span<const std::string> names, std::uint64_t scene_hash) {
  const auto parsed = parse_toml(text);
  if (!parsed) return tl::unexpected(parsed.error());
  return AnnotationsParser(*parsed, names).parse(scene_hash);
}

Result<AnnotationsRead> read_annotations(const std::filesystem::path& path, std::span<const std::string> names, std::uint64_t scene_hash) {
  const Result<std::string> bytes = read_file_bytes(path, kMaxBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto read = parse_annotations(*bytes, names, scene_hash);
  if (!read) return fail("{}: {}", path.string(), read.error().what);
  return read;
}

}  // namespace hapton
