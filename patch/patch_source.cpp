#include "patch/patch_source.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace hapton {
namespace {

constexpr std::int64_t kPlanEveryNs = 20'000'000;
constexpr std::int64_t kLeastPatienceNs = 150'000'000;  // the hub's status comes ten times a second
constexpr std::uint32_t kReordered = 64;                // a part this many serials before the newest received one counts as lost
// Where the round trip is longer than this a part that got lost would be missed for long: it is sent again before it can be confirmed.
constexpr double kLongRoundTripS = 0.3;
constexpr double kBurstBytes = 5000.0;
// Envelope, seal, UDP and IP round a part's own numbers.
constexpr double kOverheadBytes = 150.0;

double bytes_of(const PatchTile& tile) {
  return kOverheadBytes + static_cast<double>(PatchTile::kVertexBytes) * tile.vertex_count + 3.0 * tile.triangle_count;
}
double bytes_of(const PatchCell& cell) { return kOverheadBytes + 3.0 * cell.tile_count; }
double bytes_of(const PatchBegin&) { return kOverheadBytes; }

double bytes_of(const Message& message) {
  if (const auto* tile = std::get_if<PatchTile>(&message)) return bytes_of(*tile);
  if (const auto* cell = std::get_if<PatchCell>(&message)) return bytes_of(*cell);
  return bytes_of(std::get<PatchBegin>(message));
}

}  // namespace

PatchSource::PatchSource(TiledScene scene, double probe_radius_m, std::uint64_t scene_hash, std::uint32_t epoch, const Options& options)
    : scene_(std::move(scene)),
      begin_{epoch, 0, scene_.grid.origin_m, scene_.grid.step_m, probe_radius_m, scene_hash},
      options_(options),
      items_(1 + scene_.cells.size() + scene_.tiles.size()),
      in_flight_(kSerials, 0),
      credit_bytes_(kBurstBytes) {}

std::int64_t PatchSource::patience_ns() const noexcept {
  const double round_trip_s = std::min(round_trip_s_, 10.0);
  const double wait_s = round_trip_s < kLongRoundTripS ? 1.2 * round_trip_s : 0.5 * round_trip_s;
  return kLeastPatienceNs + static_cast<std::int64_t>(1e9 * wait_s);
}

bool PatchSource::is_due(const Item& item, std::int64_t now_ns) const noexcept {
  return item.state == State::missing || (item.state == State::sent && now_ns - item.sent_ns > patience_ns());
}

void PatchSource::accept(const PatchStatus& status) noexcept {
  round_trip_s_ = status.round_trip_s;
  // The hub has started again: what it had is gone.
  if (status.epoch == 0 && counts_.held > 0) {
    std::fill(items_.begin(), items_.end(), Item());
    counts_.held = 0;
  }
  if (status.epoch != begin_.epoch || status.newest_serial > serial_) return;
  for (std::uint32_t back = 0; back < PatchStatus::kSerials && back < status.newest_serial; ++back) {
    const std::uint32_t serial = status.newest_serial - back;
    if (serial_ - serial >= kSerials) break;
    Item& item = items_[in_flight_[serial % kSerials]];
    const bool is_received = ((status.received[back / 8] >> (back % 8)) & 1U) != 0;
    if (is_received && item.state != State::held) {
      item.state = State::held;
      ++counts_.held;
    } else if (!is_received && back >= kReordered && item.state == State::sent && item.serial == serial) {
      item.state = State::missing;
    }
  }
}

// Of a box to where the hand is; what lies ahead counts as farther away by half of how far ahead it is.
double PatchSource::distance_of(const Box& bounds) const noexcept {
  double nearest = std::sqrt(bounds.distance_squared(ahead_[0]));
  for (std::size_t i = 1; i < ahead_.size(); ++i) {
    nearest = std::min(nearest, std::sqrt(bounds.distance_squared(ahead_[i])) + 0.5 * (ahead_[i] - ahead_[0]).norm());
  }
  return nearest;
}

// The cells nearest to the hand first, each before its tiles: without its cell a tile is of no use.
void PatchSource::plan(std::int64_t now_ns) {
  planned_.clear();
  planned_ns_ = now_ns;
  if (is_due(items_[0], now_ns)) planned_.push_back(0);
  const double lead_s = 0.1 + round_trip_s_;
  for (std::size_t i = 0; i < ahead_.size(); ++i) {
    ahead_[i] = scene_.grid.to_steps(hand_.p_SD + static_cast<double>(i) / 2.0 * lead_s * hand_.v_SD);
  }
  const double reach = (options_.least_reach_m + 2.0 * lead_s * options_.fastest_m_per_s) / scene_.grid.step_m;
  using Near = std::pair<double, std::size_t>;
  std::priority_queue<Near, std::vector<Near>, std::greater<>> nearest;
  if (!scene_.nodes.empty()) nearest.emplace(distance_of(scene_.nodes[0].key.bounds()), 0);
  // What has not been sent comes before what may have arrived.
  std::vector<std::size_t> again;
  const auto add = [&](std::size_t item) {
    if (items_[item].state == State::missing) planned_.push_back(item);
    if (items_[item].state == State::sent && again.size() < kPlanned && is_due(items_[item], now_ns)) again.push_back(item);
  };
  while (!nearest.empty() && planned_.size() < kPlanned && nearest.top().first <= reach) {
    const TileNode node = scene_.nodes[nearest.top().second];
    nearest.pop();
    if (node.first_child >= 0) {
      for (std::size_t octant = 0; octant < 8; ++octant) {
        const std::size_t child = static_cast<std::size_t>(node.first_child) + octant;
        nearest.emplace(distance_of(scene_.nodes[child].key.bounds()), child);
      }
    } else if (node.cell >= 0) {
      const auto cell = static_cast<std::size_t>(node.cell);
      add(item_of_cell(cell));
      for (const std::uint32_t tile : scene_.cells[cell].tiles) add(item_of_tile(tile));
    }
  }
  planned_.insert(planned_.end(), again.begin(), again.end());
  std::reverse(planned_.begin(), planned_.end());
}

Message PatchSource::make_message(std::size_t item) {
  if (item == 0) {
    begin_.serial = serial_;
    return begin_;
  }
  if (item < item_of_tile(0)) return to_message(scene_.cells[item - item_of_cell(0)], begin_.epoch, serial_);
  PatchTile tile = scene_.tiles[item - item_of_tile(0)];
  tile.epoch = begin_.epoch;
  tile.serial = serial_;
  return tile;
}

bool PatchSource::pay(const Message& message, std::int64_t now_ns) noexcept {
  const double passed_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(now_ns - credited_ns_, 0));
  credited_ns_ = now_ns;
  credit_bytes_ = std::min(kBurstBytes, credit_bytes_ + passed_s * options_.bits_per_s / 8.0);
  const double bytes = bytes_of(message);
  if (credit_bytes_ < bytes) return false;
  credit_bytes_ -= bytes;
  counts_.bytes += static_cast<std::uint64_t>(bytes);
  return true;
}

std::optional<Message> PatchSource::take(std::int64_t now_ns) {
  if (now_ns - planned_ns_ >= kPlanEveryNs || planned_ns_ == 0) plan(now_ns);
  while (!planned_.empty() && !is_due(items_[planned_.back()], now_ns)) planned_.pop_back();
  if (planned_.empty()) return std::nullopt;
  ++serial_;
  const std::size_t at = planned_.back();
  Message message = make_message(at);
  if (!pay(message, now_ns)) {
    --serial_;
    return std::nullopt;
  }
  planned_.pop_back();
  Item& item = items_[at];
  ++counts_.sent;
  counts_.repeated += item.serial != 0 ? 1 : 0;
  item = {State::sent, serial_, now_ns};
  in_flight_[serial_ % kSerials] = static_cast<std::uint32_t>(at);
  return message;
}

}  // namespace hapton
