#include "vision_node/show_recording.h"

#include "hid/hidapi_transport.h"
#include "recording/recording_rows.h"
#include "recording/recording_shapes.h"
#include "runtime/log.h"
#include "runtime/standard_streams.h"
#include "scene/find_scene.h"
#include "scene/scene_file.h"
#include "vision_node/carved_objects.h"
#include "vision_node/moved_objects.h"
#include "vision_node/recorded_session.h"
#include "vision_node/vision_session.h"

namespace hapton {
namespace {

// Loads the scene that the recording names, with the unit and fit that haptics_node used, unless the command line gives others.
Result<Scene> load_recorded_scene(const VisionOptions& options, const RecordingIndex& index) {
  const HapticsSetup* setup = index.find_setup(index.begin_s());
  if (!options.is_scene_given && setup == nullptr) {
    return fail("{}: the recording does not say which scene was touched; name it with --scene FILE", options.session.string());
  }
  SceneLoading loading = options.loading;
  const auto recorded = setup != nullptr ? from_code(setup->scene_loading) : std::nullopt;
  if (recorded && !options.is_loading_given) {
    loading.unit = recorded->unit;
    loading.fit = recorded->fit;
  }
  auto scene = load_scene(find_scene(options.is_scene_given ? options.scene : std::filesystem::path(setup->scene.data())), loading);
  if (!scene && !options.is_scene_given) return fail("{}; give its present place with --scene FILE", scene.error().what);
  return scene;
}

Result<void> check_moment(const VisionOptions& options, const RecordingIndex& index) {
  if (!options.at_s || (*options.at_s >= index.begin_s() && *options.at_s <= index.end_s())) return {};
  return fail("--at {:g}: {} has samples from {:.3f} s to {:.3f} s", *options.at_s, options.session.string(), index.begin_s(),
              index.end_s());
}

Result<void> show(VisionOptions& options, const RecordingIndex& index, HeadTracker* head, Clock& clock, const StopSignal& stop) {
  if (const auto possible = check_moment(options, index); !possible) return possible;
  auto rows = RecordingRows::open(options.session, index);
  if (!rows) return tl::unexpected(rows.error());
  const auto scene = load_recorded_scene(options, index);
  if (!scene) return tl::unexpected(scene.error());
  for (const auto& note : scene->notes) log_info("{}", note);
  std::vector<std::string> tool_notes;
  const auto tool = find_tool(options.tool, *scene, options.loading, tool_notes);
  if (!tool) return tl::unexpected(tool.error());
  for (const auto& note : tool_notes) log_info("tool: {}", note);
  auto view = open_view(*scene, options);
  if (!view) return tl::unexpected(view.error());
  if (*tool) (*view)->set_tool(**tool);
  MovedObjects moved(**view, *scene);
  auto shapes = RecordingShapes::open(options.session);
  if (!shapes) return tl::unexpected(shapes.error());
  CarvedObjects carved(**view, *scene);
  const auto marks = RecordedMarks::open(**view, *scene, options.scene_radius_m, options.annotations.file, moved);
  if (!marks) return tl::unexpected(marks.error());
  RecordedSession session(**view, clock, options, index, *rows);
  session.set_scene(scene->given_hash);
  session.set_moved_objects(&moved, &*shapes);
  session.set_carved_objects(&carved);
  session.set_marks(*scene, marks->get());
  TeachBuilder teacher(scene->touch_scene());
  session.set_teacher(&teacher);
  session.set_head_tracker(head);
  std::optional<SpaceHead> space_head;
  if (options.has_space_head) session.set_space_head(&space_head.emplace(make_hid_opener(HidKind::space_mouse, "")));
  const auto ended = session.run(stop);
  print_text("vision_node: {}; shown until {:.3f} s of the recording\n", session.step().frames().describe(), session.player().moment_s());
  return ended;
}

}  // namespace

int show_recording(VisionOptions& options, HeadTracker* head, Clock& clock, const StopSignal& stop) {
  auto reader = SessionReader::open(options.session);
  if (!reader) {
    log_error("--session {}", reader.error().what);
    return 1;
  }
  const auto index = RecordingIndex::read(*reader);
  if (!index) {
    log_error("--session {}: {}", options.session.string(), index.error().what);
    return 1;
  }
  const std::string problem = reader->problem();
  if (!problem.empty()) log_warning("--session {}", problem);
  log_info("recording of {:.3f} s, {} markers and faults", index->end_s() - index->begin_s(), index->marks().size());
  if (const auto shown = show(options, *index, head, clock, stop); !shown) {
    log_error("{}", shown.error().what);
    return 1;
  }
  return problem.empty() ? 0 : 1;
}

}  // namespace hapton
