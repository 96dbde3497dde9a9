#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/haptons/edge_pairs.h"
#include "bench/measure/run_conditions.h"

namespace hapton {

// The memo's figure for its own machine (4.1): "performed at the 1 hapton level but is capable of approximately 5 haptons".
constexpr double kMemoHaptons = 1.0;
constexpr double kMemoCapableHaptons = 5.0;
constexpr double kHaptonAccuracy = 1e-3;  // memo 3.0: "to a spatial accuracy of 0.1% or better"

// An algorithm that collides triangle pairs.
class PairCollider {
 public:
  virtual ~PairCollider() = default;
  virtual std::string name() const = 0;
  virtual std::string what() const = 0;  // description for people: what is timed
  virtual bool is_peer() const = 0;      // true: an algorithm of another library
  // The timed work: collides pairs first to first + count - 1. Pre: first and count are multiples of 8.
  virtual void collide(std::size_t first, std::size_t count) = 0;
  // Error of the contact found last for a pair: its distance from the exact contact, divided by the longest edge of the smaller triangle;
  // negative: no contact was found. For FCL: the distance of its best point from the exact segment, divided likewise.
  virtual double location_error(std::size_t pair) const = 0;
  // The number of pairs that a fast algorithm passed to a slower one.
  virtual std::size_t recomputed() const { return 0; }
};

// Three colliders of ours (eight pairs at once from prepared blocks; the same from double corners; one by one) and FCL's two if built in.
// Pre: the pairs outlive the colliders; their number is a multiple of 8; intersect_extended finds exactly two points for each pair.
std::vector<std::unique_ptr<PairCollider>> make_pair_colliders(const std::vector<TrianglePair>& pairs);

// FCL's two algorithms; empty if FCL was not built in. The first is its triangle test alone, the second fcl::collide on two meshes.
std::vector<std::unique_ptr<PairCollider>> make_fcl_colliders(const std::vector<TrianglePair>& pairs);

// A collider's rate and accuracy. Haptons are pairs a millisecond on one core.
struct HaptonResult {
  std::string name;
  std::string what;
  bool is_peer = false;
  double p50_haptons = 0.0;  // half of the batches were at least as fast
  double p99_haptons = 0.0;  // 99 % of the batches were at least as fast
  double best_haptons = 0.0;
  std::size_t batches = 0;
  std::size_t checked = 0;     // number of pairs compared with extended precision in this run: all of them
  std::size_t missed = 0;      // number of those for which no contact was found
  std::size_t mislocated = 0;  // number of those located worse than 0.1 %
  double worst_error = 0.0;    // largest error of the contacts found, divided by the longest edge of the smaller triangle
  std::size_t recomputed = 0;

  bool holds() const { return missed == 0 && mislocated == 0; }
};

// Fills in result.checked, missed, mislocated and worst_error. An error that is not a number counts as infinite.
void count_errors(const PairCollider& collider, std::size_t pairs, HaptonResult& result);

struct HaptonRunSettings {
  EdgePairSettings pairs;
  std::size_t batch = 512;  // number of pairs whose collisions are timed together
  double seconds = 5.0;     // run time of all colliders together
};

struct HaptonRun {
  RunConditions conditions;
  HaptonRunSettings settings;
  std::vector<HaptonResult> results;

  bool holds() const;  // true: all colliders of Hapton found every pair and located it to 0.1 %
};

// Times all colliders in turn, some milliseconds each, so that other load affects all of them alike, on one CPU (CpuPin). Pre:
// settings.pairs.count is a multiple of settings.batch, and settings.batch a multiple of 8. RT: no.
HaptonRun measure_haptons(const HaptonRunSettings& settings);

std::string to_text(const HaptonRun& run);
std::string to_csv(const HaptonRun& run);
std::string to_json(const HaptonRun& run);

}  // namespace hapton
