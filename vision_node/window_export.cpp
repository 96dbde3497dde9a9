#include "vision_node/window_export.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/sculpt/carved_mesh.h"
#include "runtime/atomic_file.h"
#include "scene/annotations_file.h"
#include "scene/mesh_text.h"

namespace hapton {
namespace {

// The part of a file's name after its number, and what it has.
struct ExportPart {
  std::string ending;
  std::string bytes;
};

// A name of a scene file may have any letters.
std::string name_for_file(const std::string& name) {
  std::string letters = name;
  for (char& letter : letters) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0 && letter != '-') letter = '_';
  }
  return letters;
}

bool has_name_alone(const Scene& scene, const std::string& name) {
  return std::ranges::count(scene.objects, name, [](const SceneObject& each) { return name_for_file(each.name); }) == 1;
}

std::vector<ExportPart> make_parts(const WindowWork& work) {
  std::vector<ExportPart> parts;
  if (!work.placed.entries.empty()) parts.push_back({".vtp", write_annotations_vtp(work.placed, work.X_SO, work.scene.objects.size())});
  if (work.carved == nullptr || work.carved->list().newest_active() == 0) return parts;
  for (std::size_t o = 0; o < work.scene.objects.size(); ++o) {
    const auto field = work.carved->copy_field(o);
    if (!field) continue;
    std::string name = name_for_file(work.scene.objects[o].name);
    if (!has_name_alone(work.scene, name)) name = fmt::format("{}_{}", o, name);
    parts.push_back({"_" + name + ".stl", write_mesh(make_carved_mesh(*field), MeshTextFormat::stl)});
  }
  return parts;
}

// None of its files is there yet.
std::filesystem::path find_free(const std::filesystem::path& folder, const std::vector<ExportPart>& parts) {
  for (int number = 1;; ++number) {
    const std::filesystem::path stem = folder / fmt::format("hapton_export_{:03}", number);
    const auto is_there = [&](const ExportPart& part) { return std::filesystem::exists(stem.string() + part.ending); };
    if (std::ranges::none_of(parts, is_there)) return stem;
  }
}

}  // namespace

Result<std::string> export_work(const WindowWork& work, const std::filesystem::path& folder) {
  const std::vector<ExportPart> parts = make_parts(work);
  if (parts.empty()) return std::string("nothing to export: nothing is drawn, measured or carved");
  std::error_code error;
  const std::filesystem::path stem = find_free(std::filesystem::absolute(folder, error), parts);
  std::string names;
  for (const ExportPart& part : parts) {
    const std::filesystem::path file = stem.string() + part.ending;
    if (auto written = write_file_atomically(file, part.bytes); !written) return tl::unexpected(written.error());
    names += (names.empty() ? " " : ", ") + file.filename().string();
  }
  return "exported to " + stem.parent_path().lexically_normal().string() + ":" + names;
}

}  // namespace hapton
