#include "bench/haptons/hapton_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/haptons/extended_pair.h"
#include "bench/measure/cpu_pin.h"
#include "bench/measure/stopwatch.h"

namespace hapton {
namespace {

using Pairs = std::vector<TrianglePair>;

double error_of(const TriangleContact& contact, const TrianglePair& pair) {
  return contact.meets ? hapton::location_error(contact, intersect_extended(pair)) / size_of(pair) : -1.0;
}

class ScalarCollider final : public PairCollider {
 public:
  explicit ScalarCollider(const Pairs& pairs) : pairs_(pairs), contacts_(pairs.size()) {}
  std::string name() const override { return "scalar"; }
  std::string what() const override { return "one by one, double, exact signs"; }
  bool is_peer() const override { return false; }
  void collide(std::size_t first, std::size_t count) override {
    for (std::size_t i = first; i < first + count; ++i) contacts_[i] = intersect_triangles(pairs_[i]);
  }
  double location_error(std::size_t i) const override { return error_of(contacts_[i], pairs_[i]); }

 private:
  const Pairs& pairs_;
  std::vector<TriangleContact> contacts_;
};

// Takes blocks of eight pairs, as a mesh prepared for collision stores them. The time includes a repetition of undecided pairs in double.
class BlockCollider final : public PairCollider {
 public:
  explicit BlockCollider(const Pairs& pairs)
      : pairs_(pairs), blocks_(pairs.size() / 8), block_contacts_(blocks_.size()), recomputed_contacts_(pairs.size()) {
    for (std::size_t b = 0; b < blocks_.size(); ++b) pack_8(&pairs[8 * b], blocks_[b]);
  }
  std::string name() const override { return "simd"; }
  std::string what() const override { return "eight at once, float; undecided ones again in double"; }
  bool is_peer() const override { return false; }
  void collide(std::size_t first, std::size_t count) override {
    for (std::size_t b = first / 8; b < (first + count) / 8; ++b) {
      intersect_8(blocks_[b], block_contacts_[b]);
      for (unsigned left = block_contacts_[b].undecided; left != 0; left &= left - 1) {
        const std::size_t i = 8 * b + static_cast<std::size_t>(__builtin_ctz(left));
        recomputed_contacts_[i] = intersect_triangles(pairs_[i]);
      }
    }
  }
  double location_error(std::size_t i) const override {
    const TriangleContacts8& found = block_contacts_[i / 8];
    const auto lane = i % 8;
    if ((found.undecided >> lane & 1) != 0) return error_of(recomputed_contacts_[i], pairs_[i]);
    TriangleContact contact;
    contact.meets = (found.meets >> lane & 1) != 0;
    contact.begin = pairs_[i].a[0] + Vec3(found.begin[0][lane], found.begin[1][lane], found.begin[2][lane]);
    contact.end = pairs_[i].a[0] + Vec3(found.end[0][lane], found.end[1][lane], found.end[2][lane]);
    return error_of(contact, pairs_[i]);
  }
  std::size_t recomputed() const override {
    std::size_t sum = 0;
    for (const TriangleContacts8& found : block_contacts_) sum += static_cast<std::size_t>(__builtin_popcount(found.undecided));
    return sum;
  }

 private:
  const Pairs& pairs_;
  std::vector<TrianglePairs8> blocks_;
  std::vector<TriangleContacts8> block_contacts_;
  std::vector<TriangleContact> recomputed_contacts_;
};

// Takes corners in double precision; the time includes packing and unpacking.
class MeshCollider final : public PairCollider {
 public:
  explicit MeshCollider(const Pairs& pairs) : pairs_(pairs), contacts_(pairs.size()), recomputed_counts_(pairs.size() / 8) {}
  std::string name() const override { return "simd_from_double"; }
  std::string what() const override { return "the same from double corners to double contacts"; }
  bool is_peer() const override { return false; }
  void collide(std::size_t first, std::size_t count) override {
    recomputed_counts_[first / 8] = intersect_pairs(std::span(pairs_).subspan(first, count), std::span(contacts_).subspan(first, count));
  }
  double location_error(std::size_t i) const override { return error_of(contacts_[i], pairs_[i]); }
  std::size_t recomputed() const override {
    std::size_t sum = 0;
    for (const std::size_t n : recomputed_counts_) sum += n;
    return sum;
  }

 private:
  const Pairs& pairs_;
  std::vector<TriangleContact> contacts_;
  std::vector<std::size_t> recomputed_counts_;  // undecided pairs of the batch that begins at pair 8 * index
};

double at_quantile(const std::vector<double>& sorted_ns, double q) {
  const auto last = static_cast<double>(sorted_ns.size() - 1);
  return sorted_ns[static_cast<std::size_t>(q * last + 0.5)];
}

// Goes once through all pairs to load the cache, as in a haptic loop, then times repetitions for a few
// milliseconds.
void take_turn(PairCollider& collider, const Stopwatch& watch, const HaptonRunSettings& settings, std::vector<double>& batch_ns) {
  constexpr double kTurnNs = 5e6;  // 5 ms; a free choice
  collider.collide(0, settings.pairs.count);
  const std::uint64_t start = Stopwatch::ticks();
  do {
    for (std::size_t first = 0; first < settings.pairs.count; first += settings.batch) {
      const std::uint64_t from = Stopwatch::ticks();
      collider.collide(first, settings.batch);
      batch_ns.push_back(watch.ns_between(from, Stopwatch::ticks()));
    }
  } while (watch.ns_between(start, Stopwatch::ticks()) < kTurnNs);
}

HaptonResult judge(const PairCollider& collider, std::vector<double> batch_ns, const HaptonRunSettings& settings) {
  HaptonResult result;
  result.name = collider.name();
  result.what = collider.what();
  result.is_peer = collider.is_peer();
  std::sort(batch_ns.begin(), batch_ns.end());
  const auto haptons = [&](double ns) { return static_cast<double>(settings.batch) * 1e6 / ns; };
  result.p50_haptons = haptons(at_quantile(batch_ns, 0.5));
  result.p99_haptons = haptons(at_quantile(batch_ns, 0.99));
  result.best_haptons = haptons(batch_ns.front());
  result.batches = batch_ns.size();
  count_errors(collider, settings.pairs.count, result);
  result.recomputed = collider.recomputed();
  return result;
}

}  // namespace

std::vector<std::unique_ptr<PairCollider>> make_pair_colliders(const std::vector<TrianglePair>& pairs) {
  std::vector<std::unique_ptr<PairCollider>> colliders;
  colliders.push_back(std::make_unique<BlockCollider>(pairs));
  colliders.push_back(std::make_unique<MeshCollider>(pairs));
  colliders.push_back(std::make_unique<ScalarCollider>(pairs));
  for (auto& peer : make_fcl_colliders(pairs)) colliders.push_back(std::move(peer));
  return colliders;
}

void count_errors(const PairCollider& collider, std::size_t pairs, HaptonResult& result) {
  result.checked = pairs;
  for (std::size_t i = 0; i < pairs; ++i) {
    const double found = collider.location_error(i);
    const double error = std::isnan(found) ? std::numeric_limits<double>::infinity() : found;
    result.missed += error < 0.0 ? 1 : 0;
    result.mislocated += error > kHaptonAccuracy ? 1 : 0;
    result.worst_error = std::max(result.worst_error, error);
  }
}

bool HaptonRun::holds() const {
  return std::all_of(results.begin(), results.end(), [](const HaptonResult& r) { return r.is_peer || r.holds(); });
}

HaptonRun measure_haptons(const HaptonRunSettings& settings) {
  const std::vector<TrianglePair> pairs = make_edge_pairs(settings.pairs);
  auto colliders = make_pair_colliders(pairs);
  HaptonRun run;
  run.settings = settings;
  const Stopwatch watch = Stopwatch::calibrate();
  run.conditions = begin_conditions(watch, settings.pairs.seed);
  if (make_fcl_colliders({}).empty()) run.conditions.missing_peers.emplace_back("fcl");
  std::vector<std::vector<double>> batch_ns(colliders.size());
  const CpuPin pin;
  const std::uint64_t start = Stopwatch::ticks();
  do {
    for (std::size_t c = 0; c < colliders.size(); ++c) take_turn(*colliders[c], watch, settings, batch_ns[c]);
  } while (watch.ns_between(start, Stopwatch::ticks()) < 1e9 * settings.seconds);
  end_conditions(run.conditions, start, watch);
  for (std::size_t c = 0; c < colliders.size(); ++c) run.results.push_back(judge(*colliders[c], std::move(batch_ns[c]), settings));
  return run;
}

std::string to_text(const HaptonRun& run) {
  const HaptonRunSettings& s = run.settings;
  std::string text = fmt::format(
      "haptons: triangle pairs a millisecond on one core, triangles colliding on edge, contact located to 0.1 % (memo 3.0)\n"
      "{} pairs, {:g} .. {:g} of their size deep, each checked in extended precision; batches of {}\n{}\n\n"
      "{:<18} {:>12} {:>12} {:>12} {:>9} {:>7} {:>12} {:>8}  {}\n",
      s.pairs.count, s.pairs.shallowest, s.pairs.deepest, s.batch, run.conditions.to_text(), "", "p50", "p99", "best", "x memo 5", "missed",
      "worst error", "> 0.1 %", "what is timed");
  fmt::format_to(std::back_inserter(text), "{:<18} {:>12.0f} {:>12} {:>12} {:>9} {:>7} {:>12} {:>8}  {}\n", "memo, 1996", kMemoHaptons, "-",
                 kMemoCapableHaptons, 1, "-", "0.1 %", "-", "99 MHz HP 735: performed at 1, capable of about 5");
  for (const HaptonResult& r : run.results) {
    fmt::format_to(std::back_inserter(text), "{:<18} {:>12.0f} {:>12.0f} {:>12.0f} {:>9.0f} {:>7} {:>10.4g} % {:>8}  {}", r.name,
                   r.p50_haptons, r.p99_haptons, r.best_haptons, r.p50_haptons / kMemoCapableHaptons, r.missed, 100.0 * r.worst_error,
                   r.mislocated, r.what);
    if (r.recomputed > 0) {
      fmt::format_to(std::back_inserter(text), " ({:.1f} %)", 100.0 * static_cast<double>(r.recomputed) / static_cast<double>(r.checked));
    }
    text += '\n';
  }
  return text;
}

std::string to_csv(const HaptonRun& run) {
  std::string text =
      "name,is_peer,p50_haptons,p99_haptons,best_haptons,batches,checked,missed,worse_than_0_1_percent,worst_error,asked_again\n";
  for (const HaptonResult& r : run.results) {
    fmt::format_to(std::back_inserter(text), "{},{:d},{:.1f},{:.1f},{:.1f},{},{},{},{},{:.3g},{}\n", r.name, r.is_peer, r.p50_haptons,
                   r.p99_haptons, r.best_haptons, r.batches, r.checked, r.missed, r.mislocated, r.worst_error, r.recomputed);
  }
  return text;
}

std::string to_json(const HaptonRun& run) {
  nlohmann::ordered_json json = to_json(run.conditions, "hapton bench haptons");
  json["pairs"] = run.settings.pairs.count;
  json["batch"] = run.settings.batch;
  json["shallowest"] = run.settings.pairs.shallowest;
  json["deepest"] = run.settings.pairs.deepest;
  json["memo_haptons"] = kMemoHaptons;
  json["memo_capable_haptons"] = kMemoCapableHaptons;
  json["accuracy"] = kHaptonAccuracy;
  json["holds"] = run.holds();
  for (const HaptonResult& r : run.results) {
    json["results"].push_back({{"name", r.name},
                               {"what", r.what},
                               {"is_peer", r.is_peer},
                               {"p50_haptons", r.p50_haptons},
                               {"p99_haptons", r.p99_haptons},
                               {"best_haptons", r.best_haptons},
                               {"batches", r.batches},
                               {"checked", r.checked},
                               {"missed", r.missed},
                               {"worse_than_0_1_percent", r.mislocated},
                               {"worst_error", r.worst_error},
                               {"asked_again", r.recomputed}});
  }
  return json.dump(2) + "\n";
}

}  // namespace hapton
