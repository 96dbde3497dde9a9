#include "vision_node/pen.h"

#include <utility>

namespace hapton {

void Pen::receive(const std::optional<AnnotationPoint>& touched, std::uint32_t buttons, std::uint32_t facet) {
  ignored_buttons_ &= buttons;
  const std::uint32_t down = buttons & ~ignored_buttons_;
  const std::uint32_t pressed = down & ~last_buttons_;
  last_buttons_ = buttons;
  const bool is_key_pressed = is_key_down_ && !was_key_down_;
  was_key_down_ = is_key_down_;

  const bool is_draw_down = (down & settings_.draw_buttons) != 0 || is_key_down_;
  const bool draws = mode_ == PenMode::draw && is_draw_down && touched.has_value();
  if (!draws || (thinner_ && touched->object != stroke_object_)) finish_stroke();
  if (draws) draw(*touched, facet);

  const bool is_draw_pressed = (pressed & settings_.draw_buttons) != 0 || is_key_pressed;
  const bool measures = (pressed & settings_.measure_buttons) != 0 || std::exchange(has_measure_key_, false) ||
                        (mode_ == PenMode::measure && is_draw_pressed);
  if (measures && touched) end_measure(*touched);
}

void Pen::set_mode(PenMode mode) {
  if (mode == mode_) return;
  finish_stroke();
  is_key_down_ = false;
  mode_ = mode;
  ++revision_;
}

void Pen::draw(const AnnotationPoint& at, std::uint32_t facet) {
  if (!check_room(thinner_ ? thinner_->points().size() + 1 : 1)) return;
  if (!thinner_) {
    thinner_.emplace(settings_.bound_m);
    stroke_object_ = at.object;
    stroke_facet_ = facet;
  }
  const bool is_other_facet = facet != stroke_facet_;
  if (is_other_facet) thinner_->keep_last();
  if (!thinner_->add(at.p_O)) return;
  if (is_other_facet) thinner_->keep_last();
  stroke_facet_ = facet;
  ++revision_;
}

void Pen::finish_stroke() {
  if (!thinner_) return;
  add(Stroke{stroke_object_, thinner_->points()});
  thinner_.reset();
}

void Pen::end_measure(const AnnotationPoint& at) {
  ++revision_;
  if (!first_end_) {
    first_end_ = at;
    return;
  }
  if (check_room(2)) add(Measure{{*first_end_, at}});
  first_end_.reset();
}

void Pen::add(Annotation entry) {
  annotations_.entries.push_back(std::move(entry));
  point_count_ = count_points(annotations_);
  undone_entries_.clear();
  finished_entry_ = annotations_.entries.size() - 1;
  ++revision_;
  ++entries_revision_;
}

bool Pen::check_room(std::size_t points) {
  if (point_count_ + points <= kMaxAnnotationPoints) {
    is_full_reported_ = false;
    return true;
  }
  is_full_report_due_ = is_full_report_due_ || !std::exchange(is_full_reported_, true);
  return false;
}

bool Pen::undo() {
  is_key_down_ = false;
  if (std::exchange(first_end_, std::nullopt)) {
    ++revision_;
    return true;
  }
  finish_stroke();
  // A draw button that is down now must be pressed again to draw on.
  ignored_buttons_ |= last_buttons_ & settings_.draw_buttons;
  if (annotations_.entries.empty()) return false;
  undone_entries_.push_back(std::move(annotations_.entries.back()));
  annotations_.entries.pop_back();
  point_count_ = count_points(annotations_);
  finished_entry_.reset();
  ++revision_;
  ++entries_revision_;
  return true;
}

bool Pen::redo() {
  if (undone_entries_.empty()) return false;
  annotations_.entries.push_back(std::move(undone_entries_.back()));
  undone_entries_.pop_back();
  point_count_ = count_points(annotations_);
  ++revision_;
  ++entries_revision_;
  return true;
}

void Pen::replace(Annotations given) {
  finish_stroke();
  annotations_ = std::move(given);
  point_count_ = count_points(annotations_);
  undone_entries_.clear();
  first_end_.reset();
  finished_entry_.reset();
  ++revision_;
  ++entries_revision_;
}

void Pen::set_put_down(std::vector<PutDown> put_down) {
  annotations_.put_down = std::move(put_down);
  ++entries_revision_;
  ++revision_;
}

std::optional<std::size_t> Pen::take_finished() { return std::exchange(finished_entry_, std::nullopt); }

bool Pen::take_full_report() { return std::exchange(is_full_report_due_, false); }

}  // namespace hapton
