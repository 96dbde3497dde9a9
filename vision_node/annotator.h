#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "link/messages.h"
#include "scene/scene_file.h"
#include "vision_node/annotated_surfaces.h"
#include "vision_node/annotator_options.h"
#include "vision_node/interaction.h"
#include "vision_node/pen.h"
#include "vision_node/stereo_view.h"
#include "vision_node/touch_menu.h"
#include "vision_node/undo_moment.h"
#include "vision_node/window_export.h"

namespace hapton {

// Drawing and measuring on the scene: joins the pen, the menu in the workspace, what is drawn of both and the files. Its destructor
// finishes exports. Threads: the window's. RT: no.
class Annotator {
 public:
  // How far a stroke may be from the points touched, as a share of the diameter of a sphere around the scene: a tenth of a pixel of a
  // picture of 720 lines that shows the whole scene.
  static constexpr double kBoundShare = 0x1p-13;

  // Pre: all outlive this; the view was opened with the scene's objects. can_touch: whether what is touched is a point, not a rigid tool.
  // Error: as check_annotator_options; a file that cannot be read, is not an annotation file, or cannot be written.
  static Result<std::unique_ptr<Annotator>> open(StereoView& view, const Scene& scene, double scene_radius_m,
                                                 const AnnotatorOptions& options, bool can_touch);

  // What knows the shape of objects that are carved. Pre: it outlives this.
  void set_carved_objects(const CarvedObjects* carved) {
    carved_ = carved;
    surfaces_.set_carved_objects(carved);
  }

  // What knows the shapes of objects that programs deform. Pre: as AnnotatedSurfaces::set_moved_objects.
  void set_moved_objects(const MovedObjects* moved) { surfaces_.set_moved_objects(moved); }

  // Another scene is shown. What was drawn stays on the objects of the same names; if the objects are not the same by name, nothing can be
  // undone. Pre: all outlive this; the scene before is still there.
  void change_scene(const Scene& scene, const CarvedObjects* carved, const MovedObjects* moved = nullptr);

  // Each state received, in order. X_WS: the pose of the scene that its contact was computed with.
  void receive(const ProbeState& state, const Pose& X_WS);
  // Where an object is.
  void receive(const ObjectPose& pose);
  // Where the objects are that move by keyframes (MovedObjects::moving); what is drawn on them goes along.
  void place_moving(const std::vector<Pose>& X_SO);
  // haptics_node has another scene: its objects are not those shown.
  void set_other_scene(bool is_other) { is_other_scene_ = is_other; }

  // The person's keys.
  void handle(const UserRequests& requests, const StereoScreen& screen, const Vec3& p_WC);
  // The point of the open menu under a pixel of the first eye's picture.
  std::optional<Vec3> find_menu(const StereoScreen& screen, PictureSize size, int x_px, int y_px) const;

  // A request to haptics_node that is due: an object is to be put back where it was. Repeated until its reply comes. Time: any monotonic
  // clock, ns.
  std::optional<ObjectPose> take_due(std::int64_t now_ns);

  // The same: carves are to be undone. Repeated until an undo of them comes.
  std::optional<CarveUndo> take_carve_undo(std::int64_t now_ns);

  // Counts what would change the picture.
  std::uint64_t revision() const { return pen_.revision() + own_revision_; }
  // What is drawn next: the newest strokes, measures and menu.
  void show(const Pose& X_WS);
  // A line for the picture's corner; empty before anything was drawn.
  std::string describe() const;
  // Another one, once: where something was saved or exported, or why not. Empty: nothing was.
  std::string take_notice();

  // At the end: writes what has changed, where there is a file for it. Error: one that cannot be written.
  Result<void> finish();

  const Pen& pen() const { return pen_; }
  const TouchMenu& menu() const { return menu_; }

 private:
  Annotator(StereoView& view, const Scene& scene, const AnnotatorOptions& options, const PenSettings& pen, Annotations given,
            bool can_touch);
  std::optional<AnnotatedSurfaces::Touched> find_touched(const ProbeState& state, const Pose& X_WS);
  bool has_marks() const { return !pen_.annotations().entries.empty() || pen_.current() != nullptr || pen_.first_end(); }
  void change_objects(const Scene& scene);
  void renumber_saved(std::vector<std::string> objects, const Scene& scene);
  void show_objects();
  void show_current();
  const Annotations& place_entries();
  bool is_undoing() const { return request_ || carve_undo_; }
  void undo();
  void undo_more();
  bool undo_move(std::uint32_t newest_carve);
  bool undo_carves(std::uint32_t newest_carve);
  UndoMoment now() const;
  std::uint32_t find_carve(const UndoMoment& moment) const;
  void note_entries();
  bool has_given_carves() const;
  void check_given_carves();
  Annotations collect() const;
  void choose(TouchMenu::Entry entry);
  void toggle_menu(const StereoScreen& screen, const Vec3& p_WC);
  void log_finished();
  void save();
  void begin_export();
  Result<void> write_files(const std::filesystem::path& file);

  StereoView& view_;
  const Scene* scene_;
  AnnotatorOptions options_;
  bool can_touch_;
  Pen pen_;
  TouchMenu menu_;
  AnnotatedSurfaces surfaces_;
  Annotations placed_;                // entries in the present shape, where objects deform
  std::vector<Vec3> placed_current_;  // and the stroke that is being drawn
  std::uint64_t shape_shown_ = 0;     // revision of the surfaces in the view
  std::vector<ObjectPose> poses_;     // by object; a serial of 0: where the scene file has it
  ObjectPoses X_SO_;
  bool has_moved_ = false;  // by keyframes, since they were shown
  // An object was put down elsewhere.
  struct Move {
    ObjectPose before;
    std::size_t entries = 0;  // strokes and measures that there were then
    UndoMoment moment;
  };
  std::vector<ObjectPose> at_rest_;  // by object: where it was last put down
  std::vector<Move> moves_;
  std::optional<Move> undone_move_;    // of the request
  std::optional<ObjectPose> request_;  // its serial: of the pose that is to be undone
  std::int64_t request_end_ns_ = 0;    // 0: not sent yet
  std::int64_t request_next_ns_ = 0;
  const CarvedObjects* carved_ = nullptr;
  std::vector<UndoMoment> done_;         // by entry: when it was finished
  std::optional<CarveUndo> carve_undo_;  // requested
  std::size_t more_undos_ = 0;           // requested while another one was under way
  std::int64_t undo_end_ns_ = 0;         // 0: not sent yet
  std::int64_t undo_next_ns_ = 0;
  std::vector<CarvedPress> saved_carved_;  // as the file has them
  bool are_given_checked_ = false;
  std::int32_t held_ = -1;
  bool is_other_scene_ = false;
  std::uint32_t last_buttons_ = ~0U;
  bool wants_menu_ = false;
  std::string notice_;
  WindowExport export_;
  std::optional<TouchMenu::Entry> chosen_;
  std::uint64_t own_revision_ = 0;   // of the menu, and of lengths in the corner
  std::uint64_t shown_ = 0;          // revision of the pen in the view
  std::uint64_t shown_entries_ = 0;  // and of its entries
  std::uint64_t saved_entries_ = 0;
};

}  // namespace hapton
