#include "vision_node/annotator.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/base/button_bit.h"
#include "runtime/atomic_file.h"
#include "runtime/log.h"
#include "scene/annotations_file.h"
#include "vision_node/annotation_figure.h"
#include "vision_node/annotation_text.h"
#include "vision_node/menu_figure.h"

namespace hapton {
namespace {

PutDown put_down_of(const ObjectPose& pose) { return {pose.object, pose.p_m, pose.q}; }

// Numbers the objects as another scene does. They are found by name, as when a file is read.
Result<Annotations> renumber(const Annotations& given, const Scene& from, const Scene& to) {
  auto read = parse_annotations(write_annotations(given, from.given_hash), list_names(to), to.given_hash);
  if (!read) return tl::unexpected(read.error());
  return std::move(read->annotations);
}

}  // namespace

Result<std::unique_ptr<Annotator>> Annotator::open(StereoView& view, const Scene& scene, double scene_radius_m,
                                                   const AnnotatorOptions& options, bool can_touch) {
  if (const auto checked = check_annotator_options(options); !checked) return tl::unexpected(checked.error());
  if (const auto checked = check_writable_files(options); !checked) return tl::unexpected(checked.error());
  const std::vector<std::string> names = list_names(scene);
  Annotations given;
  given.objects = names;
  if (!options.file.empty() && std::filesystem::exists(options.file)) {
    auto read = read_annotations(options.file, names, scene.given_hash);
    if (!read) return tl::unexpected(read.error());
    log_info("{}: {}", options.file.string(), describe_entries(read->annotations));
    if (const std::string misfit = read->describe_misfit(); !misfit.empty()) log_warning("{}: {}", options.file.string(), misfit);
    given = std::move(read->annotations);
  }
  PenSettings pen;
  pen.draw_buttons = button_bit(options.draw_button);
  pen.measure_buttons = button_bit(options.measure_button);
  pen.bound_m = kBoundShare * 2.0 * scene_radius_m;
  return std::unique_ptr<Annotator>(new Annotator(view, scene, options, pen, std::move(given), can_touch));
}

Annotator::Annotator(StereoView& view, const Scene& scene, const AnnotatorOptions& options, const PenSettings& pen, Annotations given,
                     bool can_touch)
    : view_(view),
      scene_(&scene),
      options_(options),
      can_touch_(can_touch),
      pen_(pen, std::move(given)),
      surfaces_(scene),
      poses_(scene.objects.size()),
      X_SO_(scene.objects.size(), Pose::Identity()),
      put_down_poses_(scene.objects.size()),
      saved_presses_(pen_.annotations().carved),
      export_(options.export_folder),
      saved_entries_revision_(pen_.entries_revision()) {
  view_.annotation_figure().set_bound(pen.bound_m);
  for (const std::size_t before : pen_.annotations().carved_before) entry_moments_.push_back({.saved_presses = before});
  for (std::size_t o = 0; o < put_down_poses_.size(); ++o) put_down_poses_[o].object = static_cast<std::int32_t>(o);
}

void Annotator::change_scene(const Scene& scene, const CarvedObjects* carved, const MovedObjects* moved) {
  pen_.finish();
  log_finished();
  if (list_names(scene) != list_names(*scene_)) change_objects(scene);
  scene_ = &scene;
  surfaces_ = AnnotatedSurfaces(scene);
  set_carved_objects(carved);
  if (moved != nullptr) set_moved_objects(moved);
  carve_undo_.reset();
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    if (object.motion == nullptr && object.commanded == nullptr && poses_[o].serial == 0) X_SO_[o] = Pose::Identity();
  }
  shown_shape_revision_ = shown_pen_revision_ = shown_entries_revision_ = ~std::uint64_t{0};
  show_objects();
  have_objects_moved_ = true;
  ++own_revision_;
}

void Annotator::change_objects(const Scene& scene) {
  Annotations before = pen_.annotations();
  before.carved_before.clear();  // these are the numbers of the file; entry_moments_ has the present ones
  auto read = renumber(before, *scene_, scene);
  if (!read) log_warning("what was drawn is left out: {}", read.error().what);
  Annotations kept;
  kept.objects = list_names(scene);
  if (read) kept = std::move(*read);
  renumber_saved(std::move(before.objects), scene);
  const bool is_saved = saved_entries_revision_ == pen_.entries_revision();
  pen_.replace(std::move(kept));
  if (is_saved) saved_entries_revision_ = pen_.entries_revision();
  poses_.assign(scene.objects.size(), {});
  X_SO_.assign(scene.objects.size(), Pose::Identity());
  put_down_poses_.assign(scene.objects.size(), {});
  for (std::size_t o = 0; o < put_down_poses_.size(); ++o) put_down_poses_[o].object = static_cast<std::int32_t>(o);
  moves_.clear();
  put_back_request_.reset();
  held_object_ = -1;
}

// Renumbers the carves that were saved last. Those with which the file began are the pen's; the file may have others by now.
void Annotator::renumber_saved(std::vector<std::string> objects, const Scene& scene) {
  Annotations saved;
  saved.objects = std::move(objects);
  saved.carved = std::move(saved_presses_);
  auto read = renumber(saved, *scene_, scene);
  if (!read) log_warning("what was carved is left out: {}", read.error().what);
  saved_presses_ = read ? std::move(read->carved) : std::vector<CarvedPress>();
}

// The point of the drawn surface that is closest to the probe. It is not the centre of a sphere probe, and it is on the drawn surface also
// where that differs from the felt one (sealed cracks, bumps). States that come while a finder is made wait in the socket.
std::optional<AnnotatedSurfaces::TouchedPoint> Annotator::find_touched(const ProbeState& state, const Pose& X_WS) {
  const auto object = static_cast<std::size_t>(state.object);
  const bool is_known = state.contact && state.object >= 0 && object < scene_->objects.size() && !is_other_scene_;
  if (!is_known || !can_touch_ || held_object_ >= 0) return std::nullopt;
  const Vec3 p_WP = state.p_WD + state.visual_offset_m;
  if (!p_WP.allFinite()) return std::nullopt;
  const Vec3 p_O = X_SO_[object].inverse(Eigen::Isometry) * (X_WS.inverse(Eigen::Affine) * p_WP);
  return surfaces_.find_closest(object, p_O);
}

void Annotator::receive(const ProbeState& state, const Pose& X_WS) {
  surfaces_.set_time(state.scene_time_ns);
  const std::uint32_t pressed = state.buttons & ~std::exchange(last_buttons_, state.buttons);
  wants_menu_ = wants_menu_ != ((pressed & button_bit(options_.menu_button)) != 0);
  const Vec3 p_WP = state.p_WD + state.visual_offset_m;
  const auto lit_before = menu_.lit();
  if (const auto entry = menu_.receive(p_WP, state.buttons & ~button_bit(options_.menu_button))) chosen_entry_ = entry;
  if (menu_.lit() != lit_before) ++own_revision_;
  const bool is_wanted = pen_.wants_point(state.buttons) && !menu_.lit();
  const auto touched = is_wanted ? find_touched(state, X_WS) : std::nullopt;
  pen_.receive(touched ? std::optional<AnnotationPoint>({state.object, touched->p_O}) : std::nullopt, state.buttons,
               touched ? touched->facet : 0);
  log_finished();
  note_entry_moments();
}

void Annotator::log_finished() {
  if (pen_.take_full_report()) {
    log_warning("nothing more can be drawn: there are {} points; save, and start with another file", kMaxAnnotationPoints);
  }
  const auto finished = pen_.take_finished();
  if (!finished) return;
  const Annotation& entry = pen_.annotations().entries[*finished];
  const auto name = [&](std::int32_t object) -> const std::string& { return scene_->objects[static_cast<std::size_t>(object)].name; };
  if (const auto* stroke = std::get_if<Stroke>(&entry)) {
    log_info("drawn on {}: {}, {} points", name(stroke->object), describe_length(compute_length_m(surfaces_.place(*stroke))),
             stroke->points_m.size());
    return;
  }
  const Measure measure = surfaces_.place(std::get<Measure>(entry));
  const auto& [from, to] = measure.ends;
  log_info("measured {} {}", describe_length(compute_length_m(measure, X_SO_)),
           from.object == to.object ? "on " + name(from.object) : "from " + name(from.object) + " to " + name(to.object));
}

void Annotator::receive(const ObjectPose& pose) {
  if (pose.object < 0 || static_cast<std::size_t>(pose.object) >= poses_.size()) return;
  ObjectPose& known = poses_[static_cast<std::size_t>(pose.object)];
  const bool is_same = known.serial != 0 && known.is_held == pose.is_held && known.p_m == pose.p_m && known.q.coeffs() == pose.q.coeffs();
  if (is_same) {
    known.serial = std::max(1U, pose.serial);
    return;
  }
  const bool was_elsewhere = known.serial == 0 && (pose.is_held || !pose.p_m.isZero(0.0) || pose.q.coeffs() != Quat::Identity().coeffs());
  const bool has_moved = known.serial != 0 || was_elsewhere;
  const bool was_held = known.serial != 0 && known.is_held;
  known = pose;
  known.serial = std::max(1U, pose.serial);
  if (!pose.is_held) {
    ObjectPose& rest = put_down_poses_[static_cast<std::size_t>(pose.object)];
    if (was_held) {
      moves_.push_back({rest, pen_.annotations().entries.size(), present_moment()});
      moves_.back().moment.saved_presses = 0;  // another haptics_node does not know of this move
    }
    rest = pose;
  }
  if (was_elsewhere && !pose.is_held) {
    log_info("{} is not where the scene file places it", scene_->objects[static_cast<std::size_t>(pose.object)].name);
  }
  if (!has_moved) return;
  held_object_ = -1;
  std::vector<PutDown> put_down;
  for (std::size_t o = 0; o < poses_.size(); ++o) {
    const ObjectPose& each = poses_[o];
    if (each.serial == 0) continue;
    if (each.is_held) {
      held_object_ = static_cast<std::int32_t>(o);
      continue;
    }
    X_SO_[o] = put_down_of(each).pose();
    if (!each.p_m.isZero(0.0) || each.q.coeffs() != Quat::Identity().coeffs()) put_down.push_back(put_down_of(each));
  }
  // Objects that only another scene has keep their poses in the file.
  for (const PutDown& given : pen_.annotations().put_down) {
    if (static_cast<std::size_t>(given.object) >= scene_->objects.size()) put_down.push_back(given);
  }
  pen_.set_put_down(std::move(put_down));
  show_objects();
}

void Annotator::place_moving(const std::vector<Pose>& X_SO) {
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    if ((scene_->objects[o].motion == nullptr && scene_->objects[o].commanded == nullptr) || X_SO_[o].matrix() == X_SO[o].matrix())
      continue;
    X_SO_[o] = X_SO[o];
    have_objects_moved_ = true;
  }
}

void Annotator::show_objects() {
  have_objects_moved_ = false;
  view_.annotation_figure().set_objects(
      X_SO_, held_object_, held_object_ >= 0 ? put_down_of(poses_[static_cast<std::size_t>(held_object_)]).pose() : Pose::Identity());
}

void Annotator::toggle_menu(const StereoScreen& screen, const Vec3& p_WC) {
  menu_.is_open() ? menu_.close() : menu_.open(screen, p_WC);
  ++own_revision_;
}

void Annotator::handle(const UserRequests& requests, const StereoScreen& screen, const Vec3& p_WC) {
  if (requests.menu != std::exchange(wants_menu_, false)) toggle_menu(screen, p_WC);
  if (requests.draw) {
    if (const auto entry = menu_.choose()) {
      chosen_entry_ = entry;
    } else {
      pen_.toggle_draw_key();
    }
  }
  if (requests.measure) pen_.measure();
  if (requests.undo) carry_out(TouchMenu::Entry::undo);
  if (requests.redo) carry_out(TouchMenu::Entry::redo);
  if (requests.save) save();
  if (requests.export_work) begin_export();
  if (const auto entry = std::exchange(chosen_entry_, std::nullopt)) carry_out(*entry);
}

void Annotator::carry_out(TouchMenu::Entry entry) {
  ++own_revision_;
  switch (entry) {
    case TouchMenu::Entry::off:
      pen_.set_mode(PenMode::off);
      break;
    case TouchMenu::Entry::draw:
      pen_.set_mode(PenMode::draw);
      break;
    case TouchMenu::Entry::measure:
      pen_.set_mode(PenMode::measure);
      break;
    case TouchMenu::Entry::undo:
      undo();
      return;
    case TouchMenu::Entry::redo:
      if (!pen_.redo()) log_info("nothing to redo");
      return;
    case TouchMenu::Entry::save:
      save();
      return;
    case TouchMenu::Entry::export_work:
      begin_export();
      return;
    case TouchMenu::Entry::close:
      break;
  }
  menu_.close();
}

std::optional<Vec3> Annotator::find_menu_point(const StereoScreen& screen, PictureSize size, int x_px, int y_px) const {
  if (!menu_.is_open() || x_px < 0 || y_px < 0 || x_px >= size.width_px || y_px >= size.height_px) return std::nullopt;
  const Vec3 on_screen_V(((x_px + 0.5) / size.width_px - 0.5) * screen.width_m, ((y_px + 0.5) / size.height_px - 0.5) * screen.height_m,
                         0.0);
  return menu_.find_ray_point(compute_eye_position(screen, Eye::centre), screen.X_WV * on_screen_V);
}

// In a scene in which nothing deforms, these are the pen's own annotations.
const Annotations& Annotator::place_entries() {
  if (!surfaces_.has_deforming()) return pen_.annotations();
  placed_annotations_ = surfaces_.place(pen_.annotations());
  return placed_annotations_;
}

void Annotator::show_current() {
  AnnotationFigure& figure = view_.annotation_figure();
  std::optional<AnnotationPoint> first = pen_.first_end();
  if (first) first->p_O = surfaces_.place(*first);
  figure.set_first_end(first);
  const std::vector<Vec3>* current = pen_.current();
  if (current != nullptr && surfaces_.has_deforming()) {
    placed_current_stroke_ = surfaces_.place(pen_.current_object(), *current);
    current = &placed_current_stroke_;
  }
  figure.set_current_stroke(pen_.current_object(), current);
}

void Annotator::show(const Pose& X_WS) {
  AnnotationFigure& figure = view_.annotation_figure();
  figure.set_scene_pose(X_WS);
  const bool has_new_shape = std::exchange(shown_shape_revision_, surfaces_.revision()) != surfaces_.revision() && has_marks();
  const bool has_new_place = have_objects_moved_ && has_marks();
  const bool has_new_pen = std::exchange(shown_pen_revision_, pen_.revision()) != pen_.revision();
  const bool has_new_entries = std::exchange(shown_entries_revision_, pen_.entries_revision()) != pen_.entries_revision();
  if (has_new_place) show_objects();
  if (has_new_place || has_new_shape || has_new_pen) show_current();
  if (has_new_shape || has_new_entries) figure.set_entries(place_entries(), scene_->objects.size());
  // The text in the corner shows lengths, which may have changed.
  if (has_new_place || has_new_shape) ++own_revision_;
  view_.menu_figure().set(menu_, pen_.mode());
}

std::string Annotator::describe() const {
  const std::vector<Annotation>& entries = pen_.annotations().entries;
  std::string text;
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : "   ") + more; };
  if (pen_.first_end()) add("MEASURING: touch the other end and press again");
  if (pen_.current() != nullptr) {
    add("drawing");
  } else if (pen_.is_key_down()) {
    add(pen_.mode() == PenMode::off ? "the pen is off" : "pen down");
  } else if (pen_.mode() != PenMode::draw) {
    add(pen_.mode() == PenMode::off ? "the pen is off" : "the pen measures");
  }
  if (!entries.empty()) add(describe_marks(entries));
  const auto last =
      std::find_if(entries.rbegin(), entries.rend(), [](const Annotation& each) { return std::holds_alternative<Measure>(each); });
  if (last != entries.rend()) add("measured " + describe_length(compute_length_m(surfaces_.place(std::get<Measure>(*last)), X_SO_)));
  return text;
}

Result<void> Annotator::write_files(const std::filesystem::path& file) {
  if (!file.empty()) {
    Annotations all = collect();
    if (auto written = write_file_atomically(file, write_annotations(all, scene_->given_hash)); !written) return written;
    log_info("{} saved in {}", describe_entries(all), file.string());
    if (carved_ != nullptr && carved_->source() != 0 && !carved_->is_complete()) {
      log_warning("{} lacks carves that have not come from haptics_node yet; save again", file.string());
    }
    for (std::size_t i = 0; i < entry_moments_.size(); ++i) entry_moments_[i].saved_presses = all.carved_before[i];
    saved_presses_ = std::move(all.carved);
  }
  if (options_.strokes.empty()) return {};
  const auto write = options_.strokes.extension() == ".vtp" ? write_annotations_vtp : write_annotations_obj;
  if (auto written = write_file_atomically(options_.strokes, write(place_entries(), X_SO_, scene_->objects.size())); !written)
    return written;
  log_info("strokes and measures written to {}", options_.strokes.string());
  return {};
}

// Without --annotations FILE, saves under the next free name.
void Annotator::save() {
  note_entry_moments();
  std::filesystem::path file = options_.file;
  for (int i = 1; file.empty() || (options_.file.empty() && std::filesystem::exists(file)); ++i) {
    file = fmt::format("hapton_annotations_{:03}.toml", i);
  }
  if (auto written = write_files(file); !written) {
    // What a person has drawn must not be lost because a disk is full: the program goes on.
    log_warning("{}", written.error().what);
    notice_ = "NOT SAVED: " + written.error().what;
    return;
  }
  notice_ = "saved in " + std::filesystem::absolute(file).lexically_normal().string();
  saved_entries_revision_ = pen_.entries_revision();
}

void Annotator::begin_export() { export_.begin({*scene_, place_entries(), X_SO_, carved_}); }

std::string Annotator::take_notice() {
  if (std::string line = export_.take_notice(); !line.empty()) notice_ = std::move(line);
  return std::exchange(notice_, {});
}

Result<void> Annotator::finish() {
  pen_.finish();
  log_finished();
  note_entry_moments();
  const Annotations all = collect();
  if (pen_.entries_revision() == saved_entries_revision_ && all.carved == saved_presses_) return {};
  if (!options_.file.empty() || !options_.strokes.empty()) return write_files(options_.file);
  log_info("{} not saved: press w, or start with --annotations FILE", describe_entries(all));
  return {};
}

}  // namespace hapton
