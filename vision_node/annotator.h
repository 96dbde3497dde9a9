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

// Drawing and measuring on the scene: connects the pen, the menu in the workspace, the figures that draw both, and the files. Its
// destructor finishes exports. Threads: the window's. RT: no.
class Annotator {
 public:
  // How far a stroke may be from the touched points, as a share of the diameter of a sphere around the scene: about a tenth of a pixel in a
  // picture of 720 lines that shows the whole scene.
  static constexpr double kBoundShare = 0x1p-13;

  // Pre: all outlive this; the view was opened with the scene's objects. can_touch: whether a point or sphere touches the scene, not a
  // rigid tool. Error: as for check_annotator_options; a file that cannot be read, is not an annotation file, or cannot be written.
  static Result<std::unique_ptr<Annotator>> open(StereoView& view, const Scene& scene, double scene_radius_m,
                                                 const AnnotatorOptions& options, bool can_touch);

  // Sets the source of the surfaces of carved objects; null: none. Pre: it outlives this.
  void set_carved_objects(const CarvedObjects* carved) {
    carved_ = carved;
    surfaces_.set_carved_objects(carved);
  }

  // Sets the source of the shapes of objects that programs deform. Pre: as for AnnotatedSurfaces::set_moved_objects.
  void set_moved_objects(const MovedObjects* moved) { surfaces_.set_moved_objects(moved); }

  // To be called when another scene is shown. What was drawn stays on the objects with the same names. If the lists of names differ,
  // objects that were put down cannot be put back, and nothing can be redone. Pre: all outlive this; the scene before still exists.
  void change_scene(const Scene& scene, const CarvedObjects* carved, const MovedObjects* moved = nullptr);

  // Takes each state received, in order. X_WS: the pose of the scene with which its contact was computed.
  void receive(const ProbeState& state, const Pose& X_WS);
  // Takes the pose of an object that haptics_node has sent.
  void receive(const ObjectPose& pose);
  // Takes the poses of the objects that move by keyframes or by programs (MovedObjects::moving); what is drawn on them moves along.
  void place_moving(const std::vector<Pose>& X_SO);
  // Sets whether haptics_node has another scene, so that its object numbers are not those of the scene shown.
  void set_other_scene(bool is_other) { is_other_scene_ = is_other; }

  // Carries out what the person requested by keys. p_WC: the centre of the workspace, by which a menu is placed.
  void handle(const UserRequests& requests, const StereoScreen& screen, const Vec3& p_WC);
  // The point of the open menu under a pixel (from the lower left corner) of the first eye's picture; none: no menu is there.
  std::optional<Vec3> find_menu_point(const StereoScreen& screen, PictureSize size, int x_px, int y_px) const;

  // A request to haptics_node to put an object back where it was, when it is due; it is due again and again until its reply comes. Time:
  // any monotonic clock, ns.
  std::optional<ObjectPose> take_due(std::int64_t now_ns);

  // A request to haptics_node to undo carves, in the same way, until an undo of them comes.
  std::optional<CarveUndo> take_carve_undo(std::int64_t now_ns);

  // Increases with every change that would change the picture.
  std::uint64_t revision() const { return pen_.revision() + own_revision_; }
  // Hands to the view what it draws next: the newest strokes, measures and menu. X_WS: the pose of the scene in the picture.
  void show(const Pose& X_WS);
  // A line for the picture's corner; empty: nothing was drawn or measured yet, and the pen draws.
  std::string describe() const;
  // Another line, once: where something was saved or exported, or why not; empty: there is none.
  std::string take_notice();

  // At the end: writes what has changed since the last save, if the options name a file. Error: a file that cannot be written.
  Result<void> finish();

  const Pen& pen() const { return pen_; }
  const TouchMenu& menu() const { return menu_; }

 private:
  Annotator(StereoView& view, const Scene& scene, const AnnotatorOptions& options, const PenSettings& pen, Annotations given,
            bool can_touch);
  std::optional<AnnotatedSurfaces::TouchedPoint> find_touched(const ProbeState& state, const Pose& X_WS);
  bool has_marks() const { return !pen_.annotations().entries.empty() || pen_.current() != nullptr || pen_.first_end(); }
  void change_objects(const Scene& scene);
  void renumber_saved(std::vector<std::string> objects, const Scene& scene);
  void show_objects();
  void show_current();
  const Annotations& place_entries();
  bool is_undoing() const { return put_back_request_ || carve_undo_; }
  void undo();
  void undo_waiting();
  bool undo_move(std::uint32_t newest_carve);
  bool undo_carves(std::uint32_t newest_carve);
  UndoMoment present_moment() const;
  std::uint32_t find_carve(const UndoMoment& moment) const;
  void note_entry_moments();
  bool has_carves_of_file() const;
  void check_carves_of_file();
  Annotations collect() const;
  void carry_out(TouchMenu::Entry entry);
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
  Annotations placed_annotations_;           // entries in the present shape, if objects deform
  std::vector<Vec3> placed_current_stroke_;  // the stroke that is being drawn, likewise
  std::uint64_t shown_shape_revision_ = 0;   // revision of the surfaces in the view
  std::vector<ObjectPose> poses_;            // by object; serial 0: none received, it is where the scene file places it
  ObjectPoses X_SO_;
  bool have_objects_moved_ = false;  // by keyframes or by programs, since the objects were last shown
  // An object that was put down elsewhere.
  struct Move {
    ObjectPose before;
    std::size_t entries = 0;  // number of strokes and measures at that time
    UndoMoment moment;
  };
  std::vector<ObjectPose> put_down_poses_;  // by object: its pose when it was last put down
  std::vector<Move> moves_;
  std::optional<Move> undone_move_;             // the one that put_back_request_ undoes
  std::optional<ObjectPose> put_back_request_;  // serial: that of the pose that is to be undone
  std::int64_t put_back_end_ns_ = 0;            // 0: not sent yet
  std::int64_t put_back_next_ns_ = 0;
  const CarvedObjects* carved_ = nullptr;
  std::vector<UndoMoment> entry_moments_;  // by entry: when it was finished
  std::optional<CarveUndo> carve_undo_;    // the request under way
  std::size_t waiting_undos_ = 0;          // undos requested while a request was under way
  std::int64_t carve_undo_end_ns_ = 0;     // 0: not sent yet
  std::int64_t carve_undo_next_ns_ = 0;
  std::vector<CarvedPress> saved_presses_;  // carves as the file has them
  std::uint32_t checked_source_ = 0;
  std::int32_t held_object_ = -1;
  bool is_other_scene_ = false;
  std::uint32_t last_buttons_ = ~0U;
  bool wants_menu_ = false;
  std::string notice_;
  WindowExport export_;
  std::optional<TouchMenu::Entry> chosen_entry_;
  std::uint64_t own_revision_ = 0;            // of the menu, and of the lengths in the corner
  std::uint64_t shown_pen_revision_ = 0;      // revision of the pen that the view shows
  std::uint64_t shown_entries_revision_ = 0;  // revision of its entries that the view shows
  std::uint64_t saved_entries_revision_ = 0;
};

}  // namespace hapton
