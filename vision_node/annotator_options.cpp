#include "vision_node/annotator_options.h"

#include <array>
#include <iterator>
#include <utility>

#include "runtime/writable_path.h"

namespace hapton {
namespace {

// If a button had two functions, each press would do both.
Result<void> check_buttons(const AnnotatorOptions& options) {
  const std::pair<const char*, int> all[] = {
      {"--draw-button", options.draw_button}, {"--measure-button", options.measure_button}, {"--menu-button", options.menu_button}};
  for (std::size_t i = 0; i < std::size(all); ++i) {
    for (std::size_t k = i + 1; k < std::size(all); ++k) {
      if (all[i].second == 0 || all[i].second != all[k].second) continue;
      return fail("{} and {} are both {}; give them different buttons, or 0 for none", all[i].first, all[k].first, all[i].second);
    }
  }
  return {};
}

Result<void> check_names(const AnnotatorOptions& options) {
  if (!options.file.empty() && options.file.extension() != ".toml") {
    return fail("--annotations {}: annotations are kept as TOML; give it a name that ends in .toml (--strokes writes .obj and .vtp)",
                options.file.string());
  }
  if (!options.strokes.empty() && options.strokes.extension() != ".obj" && options.strokes.extension() != ".vtp") {
    return fail("--strokes {}: strokes are written as OBJ or VTP; give it a name that ends in .obj or .vtp", options.strokes.string());
  }
  return {};
}

}  // namespace

Result<void> check_annotator_options(const AnnotatorOptions& options) {
  if (auto checked = check_names(options); !checked) return checked;
  return check_buttons(options);
}

Result<void> check_writable_files(const AnnotatorOptions& options) {
  for (const auto* file : {&options.file, &options.strokes}) {
    if (file->empty()) continue;
    if (auto writable = check_writable_file(*file); !writable) return writable;
  }
  return {};
}

}  // namespace hapton
