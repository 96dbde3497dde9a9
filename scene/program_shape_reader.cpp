#include "scene/program_shape_reader.h"

#include "scene/object_reader.h"
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

}  // namespace hapton
