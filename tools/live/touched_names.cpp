#include "tools/live/touched_names.h"

#include <charconv>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "tools/session/recorded_scenes.h"

namespace hapton {
namespace {

std::string note_of(const nlohmann::ordered_json& notes, const char* name) {
  return notes.contains(name) && notes[name].is_string() ? notes[name].get<std::string>() : "";
}

template <class Number>
bool read_whole(const std::string& text, Number& number, int base) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

// How the scene was loaded, from the notes of io_node's report.
SceneLoading loading_of(const nlohmann::ordered_json& notes) {
  SceneLoading loading;
  if (const auto unit = parse_unit(note_of(notes, "scene_unit"))) loading.unit = *unit;
  loading.sealing = note_of(notes, "scene_sealed") == "no" ? CrackSealing::off : CrackSealing::on;
  loading.fit = note_of(notes, "scene_fitted") == "yes" ? MeshFit::workspace : MeshFit::off;
  return loading;
}

}  // namespace

const std::vector<ObjectName>& TouchedNames::names_of(const nlohmann::ordered_json& notes) {
  const std::string hash = note_of(notes, "scene_hash");
  const std::string shape_hash = note_of(notes, "scene_shape_hash");
  if (hash + shape_hash == hashes_) return names_;
  hashes_ = hash + shape_hash;
  names_.clear();
  HapticsSetup setup;
  if (!read_whole(hash, setup.scene_hash, 16)) return names_;
  std::uint64_t given_hash = 0;
  (void)read_whole(shape_hash, given_hash, 16);  // a hub of an earlier build does not report this hash
  put_text(note_of(notes, "scene"), setup.scene);
  setup.scene_loading = to_code(loading_of(notes));
  if (auto names = RecordedScenes().find_names(setup, given_hash)) names_ = std::move(*names);
  return names_;
}

std::string TouchedNames::describe(const nlohmann::ordered_json& report) {
  const auto found = report.find("notes");
  int object = -1;
  if (found == report.end() || !found->is_object() || !read_whole(note_of(*found, "touched_object"), object, 10) || object < 0) return {};
  const std::string name = describe_object(names_of(*found), object);
  return "touching " + (name.empty() ? "object " + std::to_string(object) : name);
}

}  // namespace hapton
