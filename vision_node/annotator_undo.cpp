// Undo of Annotator: strokes, measures, objects that were put down and carves, in the order in which they were done.
#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "runtime/log.h"
#include "vision_node/annotator.h"

namespace hapton {
namespace {

// The request is repeated so often, as a datagram may be lost; haptics_node may be building the scene again, which takes longer.
constexpr std::int64_t kRequestEveryNs = 100'000'000;
constexpr std::int64_t kRequestTimeoutNs = 10'000'000'000;  // until the object moves: two round trips of the slowest network, with loss
// Longest wait until carves are undone: haptics_node takes a fraction of a second, and about ten seconds after a million carves.
constexpr std::int64_t kUndoTimeoutNs = 20'000'000'000;

}  // namespace

// Undoes what happened last: an object was put down, material was carved, or something was drawn or measured. If the key is pressed again
// before haptics_node has undone that, one undo follows the other.
void Annotator::undo() {
  if (is_undoing()) {
    ++waiting_undos_;
    return;
  }
  note_entry_moments();
  const bool is_under_way = pen_.first_end() || pen_.current() != nullptr;
  const std::uint32_t newest_carve = carved_ != nullptr ? carved_->list().newest_active() : 0;
  if (!is_under_way && (undo_move(newest_carve) || undo_carves(newest_carve))) return;
  log_info("{}", pen_.undo() ? "undone" : "nothing to undo");
}

void Annotator::undo_waiting() {
  if (waiting_undos_ == 0 || is_undoing()) return;
  --waiting_undos_;
  undo();
  ++own_revision_;
}

UndoMoment Annotator::present_moment() const {
  if (carved_ == nullptr || carved_->source() == 0) return {.saved_presses = saved_presses_.size()};
  return {.saved_presses = saved_presses_.size(), .source = carved_->source(), .serial = carved_->list().newest()};
}

std::uint32_t Annotator::find_carve(const UndoMoment& moment) const {
  return carved_ == nullptr ? 0 : CarveMoments(carved_->list(), carved_->source(), saved_presses_).find_serial(moment);
}

// Undoes that an object was put down, if that happened last. While the stylus holds an object, this only shows a notice.
bool Annotator::undo_move(std::uint32_t newest_carve) {
  if (moves_.empty() || pen_.annotations().entries.size() > moves_.back().entries) return false;
  if (newest_carve != 0 && newest_carve > find_carve(moves_.back().moment)) return false;
  if (held_object_ >= 0) {
    notice_ = "NOT UNDONE: put down what the stylus holds, and press again";
    return true;
  }
  undone_move_ = moves_.back();
  moves_.pop_back();
  put_back_request_ = undone_move_->before;
  put_back_request_->serial = poses_[static_cast<std::size_t>(put_back_request_->object)].serial;
  put_back_end_ns_ = put_back_next_ns_ = 0;
  log_info("putting back {}", scene_->objects[static_cast<std::size_t>(put_back_request_->object)].name);
  return true;
}

std::optional<ObjectPose> Annotator::take_due(std::int64_t now_ns) {
  undo_waiting();
  if (!put_back_request_) return std::nullopt;
  const auto object = static_cast<std::size_t>(put_back_request_->object);
  if (poses_[object].serial != put_back_request_->serial) {
    put_back_request_.reset();  // the object has been moved
    return std::nullopt;
  }
  if (put_back_end_ns_ == 0) put_back_end_ns_ = now_ns + kRequestTimeoutNs;
  if (now_ns >= put_back_end_ns_) {
    log_warning("{} was not put back: haptics_node is busy, or does not reply", scene_->objects[object].name);
    put_back_request_.reset();
    moves_.push_back(*undone_move_);  // so that the person can try again
    waiting_undos_ = 0;
    return std::nullopt;
  }
  if (now_ns < put_back_next_ns_) return std::nullopt;
  put_back_next_ns_ = now_ns + kRequestEveryNs;
  return put_back_request_;
}

void Annotator::note_entry_moments() { entry_moments_.resize(pen_.annotations().entries.size(), present_moment()); }

// Undoes the carves of the last press of the button, if nothing was drawn or measured since.
bool Annotator::undo_carves(std::uint32_t newest_carve) {
  if (newest_carve == 0 || (!entry_moments_.empty() && newest_carve <= find_carve(entry_moments_.back()))) return false;
  carve_undo_ = CarveUndo{.source = carved_->source(), .serial = newest_carve};
  carve_undo_end_ns_ = carve_undo_next_ns_ = 0;
  log_info("undoing what was carved last");
  return true;
}

std::optional<CarveUndo> Annotator::take_carve_undo(std::int64_t now_ns) {
  check_carves_of_file();
  if (!carve_undo_) return std::nullopt;
  if (carved_->source() != carve_undo_->source || !carved_->list().is_active(carve_undo_->serial)) {
    carve_undo_.reset();
    return std::nullopt;
  }
  if (carve_undo_end_ns_ == 0) carve_undo_end_ns_ = now_ns + kUndoTimeoutNs;
  if (now_ns >= carve_undo_end_ns_) {
    log_warning("what was carved was not undone: haptics_node is busy, or does not reply");
    carve_undo_.reset();
    waiting_undos_ = 0;
    return std::nullopt;
  }
  if (now_ns < carve_undo_next_ns_) return std::nullopt;
  carve_undo_next_ns_ = now_ns + kRequestEveryNs;
  return carve_undo_;
}

// Whether haptics_node began with the carves of the file: its list then has the first carve of at least one press of the file, even if it
// is undone now. Carves that change nothing are not in the list.
bool Annotator::has_carves_of_file() const {
  const auto place_of = [](const Carve& carve) { return std::array{carve.from_m.x(), carve.from_m.y(), carve.from_m.z()}; };
  std::set<std::array<double, 3>> places_in_file;
  for (const CarvedPress& press : pen_.annotations().carved) {
    if (static_cast<std::size_t>(press.object) < scene_->objects.size()) places_in_file.insert(place_of(press.carves.front()));
  }
  bool is_there = places_in_file.empty();
  carved_->list().for_each({}, [&](const MadeCarve& made) { is_there = is_there || places_in_file.contains(place_of(made.carve)); });
  return is_there;
}

// Checks this once for each process of haptics_node, as soon as all its carves have come.
void Annotator::check_carves_of_file() {
  if (carved_ == nullptr || !carved_->is_complete() || checked_source_ == carved_->source()) return;
  checked_source_ = carved_->source();
  if (has_carves_of_file()) return;
  log_warning("{} has carves that haptics_node does not have; start it with --annotations {} as well to feel and see them",
              options_.file.string(), options_.file.string());
}

// Everything that is saved, in the order in which it was made. Carves of the file that haptics_node lacks, or of another scene, stay.
Annotations Annotator::collect() const {
  Annotations all = pen_.annotations();
  all.carved_before.clear();
  if (carved_ == nullptr || carved_->source() == 0) {
    all.carved = saved_presses_;  // no carve has come yet, or none since the scene was read again
    for (const UndoMoment& moment : entry_moments_) all.carved_before.push_back(moment.saved_presses);
    return all;
  }
  // Before all carves have come, those of the file may be among the rest: written twice they do no harm, left out they are lost.
  if ((checked_source_ == carved_->source() || carved_->is_complete()) && has_carves_of_file()) {
    std::erase_if(all.carved, [&](const CarvedPress& press) { return static_cast<std::size_t>(press.object) < scene_->objects.size(); });
  }
  const std::size_t kept = all.carved.size();
  std::vector<std::uint32_t> serials;
  std::vector<CarvedPress> carved = group_carves(carved_->list(), &serials);
  all.carved.insert(all.carved.end(), std::make_move_iterator(carved.begin()), std::make_move_iterator(carved.end()));
  const CarveMoments moments(carved_->list(), carved_->source(), saved_presses_);
  for (const UndoMoment& moment : entry_moments_) {
    const auto before = std::upper_bound(serials.begin(), serials.end(), moments.find_serial(moment)) - serials.begin();
    all.carved_before.push_back((moment.saved_presses > 0 ? kept : 0) + static_cast<std::size_t>(before));
  }
  return all;
}

}  // namespace hapton
