#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/annotations_file.h"

namespace hapton {
namespace {

// An entry as a polyline in frame S.
struct ExportLine {
  std::vector<Vec3> points_m;
  bool is_measure = false;
  std::int32_t object = -1;
  double length_m = 0.0;
  std::string_view name;  // the object's name
};

std::vector<ExportLine> list_lines(const Annotations& annotations, const ObjectPoses& X_SO, std::size_t scene_objects) {
  const auto is_shown = [&](std::int32_t object) { return object >= 0 && static_cast<std::size_t>(object) < scene_objects; };
  std::vector<ExportLine> lines;
  for (const Annotation& entry : annotations.entries) {
    ExportLine line;
    if (const auto* stroke = std::get_if<Stroke>(&entry)) {
      if (!is_shown(stroke->object)) continue;
      line.object = stroke->object;
      line.length_m = compute_length_m(*stroke);
      for (const Vec3& p_O : stroke->points_m) line.points_m.push_back(place({stroke->object, p_O}, X_SO));
    } else {
      const Measure& measure = std::get<Measure>(entry);
      if (!is_shown(measure.ends[0].object) || !is_shown(measure.ends[1].object)) continue;
      line.is_measure = true;
      line.object = measure.ends[0].object;
      line.length_m = compute_length_m(measure, X_SO);
      for (const AnnotationPoint& end : measure.ends) line.points_m.push_back(place(end, X_SO));
    }
    line.name = annotations.objects[static_cast<std::size_t>(line.object)];
    lines.push_back(std::move(line));
  }
  return lines;
}

// OBJ has no quotes: blanks and control characters become underscores.
std::string obj_name(std::string_view name) {
  std::string word(name);
  for (char& c : word) c = static_cast<unsigned char>(c) <= 0x20 || c == 0x7F ? '_' : c;
  return word;
}

template <class Value>
std::string data_array(std::string_view type, std::string_view name, const std::vector<Value>& values, std::string_view more = "") {
  std::string text = fmt::format("        <DataArray type=\"{}\" Name=\"{}\"{} format=\"ascii\">\n", type, name, more);
  for (const Value& value : values) text += fmt::format("          {}\n", value);
  return text + "        </DataArray>\n";
}

// Cells as VTK stores them: the point numbers of all cells in a row, and for each cell where its numbers end.
struct VtpCells {
  std::vector<std::size_t> connectivity, offsets;
  std::vector<int> kind, object;
  std::vector<double> length_m;

  void add(const ExportLine& line, std::size_t first) {
    for (std::size_t i = 0; i < line.points_m.size(); ++i) connectivity.push_back(first + i);
    offsets.push_back(connectivity.size());
    kind.push_back(line.is_measure ? 1 : 0);
    object.push_back(line.object);
    length_m.push_back(line.length_m);
  }
  std::string text(std::string_view tag) const {
    return fmt::format("      <{0}>\n{1}{2}      </{0}>\n", tag, data_array("Int64", "connectivity", connectivity),
                       data_array("Int64", "offsets", offsets));
  }
};

template <class Value>
std::vector<Value> join_lists(std::vector<Value> a, const std::vector<Value>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

std::string write_annotations_obj(const Annotations& annotations, const ObjectPoses& X_SO, std::size_t scene_objects) {
  std::string text = "# Strokes and measures, in metres\n";
  std::size_t first = 1;
  int strokes = 0;
  int measures = 0;
  for (const ExportLine& line : list_lines(annotations, X_SO, scene_objects)) {
    text += line.is_measure ? fmt::format("# {} m\ng measure_{}\n", line.length_m, ++measures)
                            : fmt::format("g stroke_{}_{}\n", ++strokes, obj_name(line.name));
    for (const Vec3& p : line.points_m) text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
    text += line.points_m.size() > 1 ? "l" : "p";
    for (std::size_t i = 0; i < line.points_m.size(); ++i) text += fmt::format(" {}", first + i);
    text += "\n";
    first += line.points_m.size();
  }
  return text;
}

// The cell data begin with those of the vertices, then come those of the lines: the order of vtkPolyData.
std::string write_annotations_vtp(const Annotations& annotations, const ObjectPoses& X_SO, std::size_t scene_objects) {
  VtpCells dots;
  VtpCells lines;
  std::string points;
  std::size_t count = 0;
  for (const ExportLine& line : list_lines(annotations, X_SO, scene_objects)) {
    (line.points_m.size() > 1 ? lines : dots).add(line, count);
    count += line.points_m.size();
    for (const Vec3& p : line.points_m) points += fmt::format("          {} {} {}\n", p.x(), p.y(), p.z());
  }
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "  <PolyData>\n    <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
      "      <CellData>\n{}{}{}      </CellData>\n"
      "      <Points>\n        <DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n{}"
      "        </DataArray>\n      </Points>\n{}{}    </Piece>\n  </PolyData>\n</VTKFile>\n",
      count, dots.offsets.size(), lines.offsets.size(), data_array("Int32", "kind", join_lists(dots.kind, lines.kind)),
      data_array("Int32", "object", join_lists(dots.object, lines.object)),
      data_array("Float64", "length_m", join_lists(dots.length_m, lines.length_m)), points, dots.text("Verts"), lines.text("Lines"));
}

}  // namespace hapton
