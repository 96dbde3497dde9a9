#include "vision_node/carved_objects.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/sculpt/closest_surface_point.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// Time from one computation of the surfaces to the next: a picture shows them no more often.
constexpr std::chrono::milliseconds kUpdatePeriod(33);
// A low priority as in DetailBuilder: the servo loop and the haptics node may run on the same cores.
constexpr int kNiceness = 5;
// Most carves that wait for the thread: they come in ten seconds or more, so the thread has to stand still for that time.
constexpr std::size_t kMaxWaitingCarves = 65'536;

Vec3 to_point(const Carves::Point& p) { return {p[0], p[1], p[2]}; }

MadeCarve to_made(const Carves::One& one, std::uint32_t serial) {
  return {.object = one.object,
          .serial = serial,
          .carve = {to_point(one.from_m), to_point(one.to_m), one.radius_m},
          .begins = one.begins,
          .undone = {.first = one.undone_first, .last = one.undone_last}};
}

}  // namespace

CarvedObjects::CarvedObjects(StereoView& view, const Scene& scene) : view_(view), scene_(scene) {
  has_bodies_ =
      std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& object) { return object.sculpt.has_value(); });
  is_busy_ = has_bodies_;
  if (has_bodies_) thread_ = start_thread([this] { run(); });
}

CarvedObjects::~CarvedObjects() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  orders_changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void CarvedObjects::take(const Carves& carves, Arrival arrival) {
  if (!has_bodies_) return;
  {
    const std::lock_guard lock(mutex_);
    // Carves that are left out here count as missing, and are requested again.
    if (count_waiting() >= kMaxWaitingCarves) return;
    const KnownCarves::News news = known_.take(carves, arrival);
    if (!news.starts_anew && news.carves.empty()) return;
    if (news.starts_anew) begin_anew();
    for (std::uint32_t n = 0; n < news.carves.size(); ++n) add_order(to_made(news.carves[n], news.first + n));
  }
  orders_changed_.notify_all();
}

void CarvedObjects::carve(std::span<const NumberedCarve> carves, bool starts_anew) {
  if (!has_bodies_ || (!starts_anew && carves.empty())) return;
  {
    const std::lock_guard lock(mutex_);
    if (starts_anew) begin_anew();
    for (const NumberedCarve& each : carves) add_order(to_made(each.carve, each.serial));
  }
  orders_changed_.notify_all();
}

// Pre: the mutex is held.
void CarvedObjects::begin_anew() {
  Order& order = open_order();
  order.starts_anew = true;
  order.carves.clear();
  received_carves_.clear();
  is_busy_ = true;
}

// Pre: the mutex is held.
void CarvedObjects::add_order(const MadeCarve& made) {
  if (!received_carves_.add(made)) return;
  open_order().carves.push_back(made);
  is_busy_ = true;
}

// The order to which the next carve is added. Pre: the mutex is held.
CarvedObjects::Order& CarvedObjects::open_order() const {
  if (orders_.empty() || orders_.back().wanted) orders_.emplace_back();
  return orders_.back();
}

// Pre: the mutex is held.
std::size_t CarvedObjects::count_waiting() const {
  std::size_t carves = 0;
  for (const Order& order : orders_) carves += order.carves.size();
  return carves;
}

std::optional<CarveStatus> CarvedObjects::take_request(std::int64_t now_ns) { return known_.take_request(now_ns); }

bool CarvedObjects::show() {
  if (!has_bodies_) return false;
  std::vector<FinishedSurface> made;
  {
    const std::lock_guard lock(mutex_);
    made.swap(finished_surfaces_);
  }
  for (FinishedSurface& one : made) view_.replace_object(one.object, std::move(one.levels));
  return !made.empty();
}

std::optional<Vec3> CarvedObjects::find_closest(std::size_t object, const Vec3& p) const {
  const std::shared_lock lock(fields_mutex_);
  const auto carved = surfaces_.find(object);
  return carved != surfaces_.end() ? find_closest_surface_point(carved->second.field(), p) : std::nullopt;
}

std::future<CarvedObjects::Fields> CarvedObjects::request_fields() const {
  std::promise<Fields> wanted;
  std::future<Fields> fields = wanted.get_future();
  if (!has_bodies_) {
    wanted.set_value({});
    return fields;
  }
  {
    const std::lock_guard lock(mutex_);
    open_order().wanted = std::move(wanted);
  }
  orders_changed_.notify_all();
  return fields;
}

bool CarvedObjects::is_up_to_date() const {
  const std::lock_guard lock(mutex_);
  return !is_busy_ && finished_surfaces_.empty();
}

void CarvedObjects::run() {
  ::setpriority(PRIO_PROCESS, 0, kNiceness);
  make_surfaces();
  Orders orders;
  while (wait_for_orders(orders)) {
    const auto next = std::chrono::steady_clock::now() + kUpdatePeriod;
    carry_out(orders);
    offer_changed();
    std::unique_lock lock(mutex_);
    is_busy_ = !orders_.empty();
    orders_changed_.wait_until(lock, next, [this] { return is_stopping_; });
  }
  // Requests for a copy of the fields are still fulfilled. Orders after the last of them would only be drawn, which is not needed any more.
  while (!orders.empty() && !orders.back().wanted) orders.pop_back();
  carry_out(orders);
}

void CarvedObjects::make_surfaces() {
  for (std::size_t o = 0; o < scene_.objects.size(); ++o) {
    const SceneObject& object = scene_.objects[o];
    if (!object.sculpt) continue;
    auto field = CarvedField::make(*object.mesh, object.sculpt->voxel_m);
    if (!field) {
      log_warning("object '{}' is drawn as its mesh: {}", object.name, field.error().what);
      continue;
    }
    const std::unique_lock lock(fields_mutex_);
    surfaces_.try_emplace(o, std::move(*field), make_detail_frame(*object.mesh));
  }
  offer_changed();
  const std::lock_guard lock(mutex_);
  is_busy_ = !orders_.empty();
}

bool CarvedObjects::wait_for_orders(Orders& orders) {
  std::unique_lock lock(mutex_);
  orders_changed_.wait(lock, [this] { return is_stopping_ || !orders_.empty(); });
  orders = std::exchange(orders_, {});
  return !is_stopping_;
}

void CarvedObjects::carry_out(Orders& orders) {
  for (Order& order : orders) {
    apply(order);
    if (order.wanted) order.wanted->set_value(copy_fields());
  }
  orders.clear();
}

void CarvedObjects::offer_changed() {
  for (auto& [number, surface] : surfaces_) {
    if (surface.has_changed()) offer(number, surface.compute_levels());
  }
}

void CarvedObjects::apply(const Order& order) {
  if (order.starts_anew) {
    const std::unique_lock lock(fields_mutex_);
    applied_carves_.clear();
    for (auto& [number, surface] : surfaces_) surface.restore();
  }
  for (const MadeCarve& made : order.carves) apply(made);
}

// Needs no lock, because only this thread changes the fields.
CarvedObjects::Fields CarvedObjects::copy_fields() const {
  Fields fields;
  for (const auto& [number, surface] : surfaces_) fields.try_emplace(number, surface.field());
  return fields;
}

void CarvedObjects::apply(const MadeCarve& made) {
  applied_carves_.add(made);
  const std::unique_lock lock(fields_mutex_);
  if (made.is_undo()) {
    for (auto& [number, surface] : surfaces_) surface.undo(applied_carves_, static_cast<int>(number), made.undone);
    return;
  }
  // A carve that comes after its undo changes nothing.
  const auto carved = surfaces_.find(static_cast<std::size_t>(made.object));
  if (carved != surfaces_.end() && applied_carves_.is_active(made.serial)) carved->second.carve(made.carve);
}

void CarvedObjects::offer(std::size_t object, std::vector<FlatLevel> levels) {
  const std::lock_guard lock(mutex_);
  const auto waiting =
      std::find_if(finished_surfaces_.begin(), finished_surfaces_.end(), [&](const FinishedSurface& one) { return one.object == object; });
  if (waiting != finished_surfaces_.end()) {
    waiting->levels = std::move(levels);
  } else {
    finished_surfaces_.push_back({object, std::move(levels)});
  }
}

}  // namespace hapton
