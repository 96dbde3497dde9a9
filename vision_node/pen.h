#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene/annotations.h"
#include "vision_node/stroke_thinner.h"

namespace hapton {

// What the draw button does.
enum class PenMode : std::uint8_t { off, draw, measure };

struct PenSettings {
  std::uint32_t draw_buttons = 0;     // buttons of the stylus that draw, one bit each; 0: none
  std::uint32_t measure_buttons = 0;  // buttons that set an end of a measure, likewise
  double bound_m = 1e-4;              // largest distance of a stroke from the touched points (StrokeThinner), m: not visible
};

// Strokes and measures from touched points, buttons and keys; undo and redo. A stroke lasts as long as a draw button is down and one object
// is touched. A measure takes two presses; each takes the point touched then. Frame O (scene/annotations.h), metres. RT: no.
class Pen {
 public:
  // given: annotations read from a file; undo removes these too, the last first.
  Pen(const PenSettings& settings, Annotations given) : settings_(settings), annotations_(std::move(given)) {}

  // Takes each state of the probe, in order. touched: the touched point; none in free space, and if that point is not known.
  // Buttons that were down at the first call do nothing until they are pressed again. facet: number of the flat part of the surface that is
  // touched, if the surface deforms; where it changes, the stroke keeps a vertex on both sides, so that it deforms with the surface.
  void receive(const std::optional<AnnotationPoint>& touched, std::uint32_t buttons, std::uint32_t facet = 0);

  void set_mode(PenMode mode);
  PenMode mode() const { return mode_; }
  // A key in place of the draw button: one press of the key puts it down, the next one up.
  void toggle_draw_key() { is_key_down_ = !is_key_down_; }
  bool is_key_down() const { return is_key_down_; }
  void release_draw_key() { is_key_down_ = false; }
  // A key in place of a press of a measure button: receive() takes it.
  void measure() { has_measure_key_ = true; }

  // Whether receive() would use a touched point: finding one costs time.
  bool wants_point(std::uint32_t buttons) const {
    return is_key_down_ || has_measure_key_ || (buttons & (settings_.draw_buttons | settings_.measure_buttons)) != 0;
  }
  // Finishes a stroke that is being drawn, at the end of the program.
  void finish() { finish_stroke(); }

  // Removes the newest: a stroke that is being drawn, the first end of a measure, or the last entry. False: there is nothing to remove.
  bool undo();
  // Restores the entry that undo removed last. False: none was removed, or something was drawn or measured since.
  bool redo();

  // Sets the objects that were put down, which are saved with the annotations.
  void set_put_down(std::vector<PutDown> put_down);

  // Replaces the annotations with those of another scene; nothing can be undone or redone then.
  void replace(Annotations given);

  const Annotations& annotations() const { return annotations_; }
  // The stroke that is being drawn; null: none.
  const std::vector<Vec3>* current() const { return thinner_ ? &thinner_->points() : nullptr; }
  std::int32_t current_object() const { return stroke_object_; }
  // The first end of a measure whose second one is awaited.
  const std::optional<AnnotationPoint>& first_end() const { return first_end_; }

  // Count changes: revision() of all that can be seen, entries_revision() of what is saved, which is entries and objects put down.
  std::uint64_t revision() const { return revision_; }
  std::uint64_t entries_revision() const { return entries_revision_; }
  // The number of the entry that was finished since the last call; none: no entry was.
  std::optional<std::size_t> take_finished();
  // True once for each time that something was rejected because there is no room (kMaxAnnotationPoints).
  bool take_full_report();

 private:
  void draw(const AnnotationPoint& at, std::uint32_t facet);
  void finish_stroke();
  void end_measure(const AnnotationPoint& at);
  void add(Annotation entry);
  bool check_room(std::size_t points);

  PenSettings settings_;
  Annotations annotations_;
  std::vector<Annotation> undone_entries_;
  PenMode mode_ = PenMode::draw;
  bool is_key_down_ = false;
  bool was_key_down_ = false;
  bool has_measure_key_ = false;
  std::uint32_t last_buttons_ = ~0U;
  std::uint32_t ignored_buttons_ = ~0U;  // down since before the first call, or since undo()
  std::optional<StrokeThinner> thinner_;
  std::int32_t stroke_object_ = -1;
  std::uint32_t stroke_facet_ = 0;  // facet of the last point of the stroke
  std::optional<AnnotationPoint> first_end_;
  std::size_t point_count_ = count_points(annotations_);  // points of all entries
  std::uint64_t revision_ = 1;
  std::uint64_t entries_revision_ = 1;
  std::optional<std::size_t> finished_entry_;
  bool is_full_report_due_ = false;
  bool is_full_reported_ = false;
};

}  // namespace hapton
