#include "scene/program_shape.h"

#include "scene/object_reader.h"
#include "scene/scene_loading.h"
#include "scene/text_cursor.h"

namespace hapton {

Result<ProgramShapeSpec> read_program_shape(const toml::table& object, const std::string& name) {
  ProgramShapeSpec spec;
  TableReader reader(object, name);
  std::string by;
  reader.read("deformed_by", by);
  if (!reader.has("deformed_by") && reader.has("reach_m")) {
    reader.fail_at("reach_m", "'reach_m' in {} goes with 'deformed_by = \"program\"': add it, or leave this out", name);
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  if (!reader.has("deformed_by")) return spec;
  spec.line = object.get("deformed_by")->source().begin.line;
  spec.is_on = by == "program";
  if (!spec.is_on) {
    reader.fail_at("deformed_by", "'deformed_by' in {} is '{}': it may be \"program\"; what deforms by itself has [[object.morph]] tables",
                   name, printable(by));
  }
  for (const char* key : {"keyframe", "animation", "morph", "moved_by"}) {
    if (object.contains(key)) reader.fail_at("deformed_by", "{} has 'deformed_by' and '{}': keep one", name, key);
  }
  for (const char* key : {"movable", "sculpt"}) {
    if (object[key].value_or(false)) reader.fail_at("deformed_by", "{} has 'deformed_by' and '{}': keep one", name, key);
  }
  if (!reader.has("reach_m")) {
    reader.fail_at("deformed_by",
                   "{} has 'deformed_by' and no 'reach_m': give how far a vertex may ever be from where it is at rest, in m "
                   "of the mesh, before scale",
                   name);
  }
  reader.read("reach_m", spec.reach_m, 0.0, kMaxLengthM, true);
  if (reader.error()) return tl::unexpected(*reader.error());
  return spec;
}

Result<std::shared_ptr<const ProgramShape>> make_program_shape(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                               const TriangleMesh& mesh, const SealReport& sealed) {
  if (!object.program_shape.is_on) return std::shared_ptr<const ProgramShape>();
  const std::size_t line = object.program_shape.line;
  if (sealed.has_sealed()) {
    return fail("line {}: programs deform '{}', and cracks of it were sealed: add seal_cracks = false, or repair it", line,
                printable(name));
  }
  if (mesh.vertices.size() > ProgramShape::kMostVertices) {
    return fail("line {}: programs deform '{}', which has {} vertices: at most {}", line, printable(name), mesh.vertices.size(),
                ProgramShape::kMostVertices);
  }
  const double scale = fit.scale * object.scale;
  return std::make_shared<const ProgramShape>(
      ProgramShape{.reach_m = scale * object.program_shape.reach_m, .to_scene = scale * object.q_SM.toRotationMatrix()});
}

}  // namespace hapton
