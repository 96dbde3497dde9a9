#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "scene/annotations.h"

namespace hapton {

// What was read from a file of annotations (TOML, docs/formats.md).
struct AnnotationsRead {
  Annotations annotations;      // numbered by the scene's objects
  std::size_t left_out = 0;     // entries on objects that the scene does not have
  bool is_other_scene = false;  // the file was made with another scene: the hash differs

  // One line for a person about entries that do not fit the scene; empty if all fit.
  std::string describe_misfit() const;
};

// As text, in the order in which things were made, put_down last: every number reads back to the same bits. scene_hash: Scene::given_hash.
std::string write_annotations(const Annotations& annotations, std::uint64_t scene_hash);

// names: of the scene's objects. An object is found by its name; where several have the same one, the first in the file is the first in the
// scene, and so on. Error: one line with the line in the text: not TOML, unknown or missing keys, numbers that are not finite or beyond
// 1,000 km, more than kMaxAnnotationPoints points, a version that is not ours.
Result<AnnotationsRead> parse_annotations(std::string_view text, std::span<const std::string> names, std::uint64_t scene_hash);
// Error: as above, with the name of the file; also a file that cannot be read, or is larger than 256 MiB.
Result<AnnotationsRead> read_annotations(const std::filesystem::path& path, std::span<const std::string> names, std::uint64_t scene_hash);

// For other programs: strokes and measures as polylines in frame S, in metres, with the objects at X_SO. Those on objects of another scene
// are left out. OBJ: a group for each entry, with elements l, or p for a dot. VTP: lines and vertices of a vtkPolyData with the cell data
// `kind` (0 stroke, 1 measure), `object` (its number in the scene; for a measure that of the first end) and `length_m`.
std::string write_annotations_obj(const Annotations& annotations, const ObjectPoses& X_SO, std::size_t scene_objects);
std::string write_annotations_vtp(const Annotations& annotations, const ObjectPoses& X_SO, std::size_t scene_objects);

}  // namespace hapton
