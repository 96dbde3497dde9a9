#include "tools/latency/latency_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "runtime/regular_file.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // far above the size of any latency.csv; a free choice
constexpr std::string_view kHeader = "hop,lower_ns,upper_ns,count";

bool is_hop_name(std::string_view name) {
  return !name.empty() &&
         std::all_of(name.begin(), name.end(), [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

std::optional<std::int64_t> parse_count(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && value >= 0 ? std::optional(value) : std::nullopt;
}

std::string_view take_until(std::string_view& text, char mark) {
  const std::size_t end = std::min(text.find(mark), text.size());
  const std::string_view head = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return head;
}

// Adds the row to the last hop, or begins a new hop. False: not a row, a hop that ended before, or a bucket that is out of order.
bool add_row(std::string_view line, std::vector<HopCounts>& hops) {
  const std::string_view name = take_until(line, ',');
  const auto lower = parse_count(take_until(line, ','));
  const auto upper = parse_count(take_until(line, ','));
  const auto count = parse_count(line);
  if (!is_hop_name(name) || !lower || !upper || !count || *upper <= *lower) {
    return false;
  }
  if (hops.empty() || hops.back().name != name) {
    if (std::any_of(hops.begin(), hops.end(), [&](const HopCounts& hop) { return hop.name == name; })) {
      return false;
    }
    hops.push_back({std::string(name), {}});
  } else if (*lower < hops.back().buckets.back().upper_ns) {
    return false;
  }
  hops.back().buckets.push_back({*lower, *upper, static_cast<std::uint64_t>(*count)});
  return true;
}

}  // namespace

std::uint64_t HopCounts::total() const {
  std::uint64_t sum = 0;
  for (const Bucket& bucket : buckets) {
    sum += bucket.count;
  }
  return sum;
}

double HopCounts::quantile_us(double share) const {
  const double target_count = share * static_cast<double>(total());
  double sum = 0.0;
  const auto reached = std::find_if(buckets.begin(), buckets.end() - 1, [&](const Bucket& bucket) {
    sum += static_cast<double>(bucket.count);
    return sum >= target_count;
  });
  return 0.5e-3 * static_cast<double>(reached->lower_ns + reached->upper_ns);
}

std::vector<HopCounts> subtract_hops(const std::vector<HopCounts>& now, const std::vector<HopCounts>& before) {
  std::vector<HopCounts> difference = now;
  for (HopCounts& hop : difference) {
    const auto earlier = std::find_if(before.begin(), before.end(), [&](const HopCounts& other) { return other.name == hop.name; });
    if (earlier == before.end() || earlier->total() > hop.total()) {
      continue;
    }
    for (const HopCounts::Bucket& bucket : earlier->buckets) {
      const auto matching_bucket =
          std::find_if(hop.buckets.begin(), hop.buckets.end(), [&](const HopCounts::Bucket& b) { return b.lower_ns == bucket.lower_ns; });
      if (matching_bucket != hop.buckets.end()) {
        matching_bucket->count -= std::min(matching_bucket->count, bucket.count);
      }
    }
    std::erase_if(hop.buckets, [](const HopCounts::Bucket& bucket) { return bucket.count == 0; });
  }
  std::erase_if(difference, [](const HopCounts& hop) { return hop.buckets.empty(); });
  return difference;
}

std::string to_csv(const std::vector<HopCounts>& hops) {
  std::string text = std::string(kHeader) + "\n";
  for (const HopCounts& hop : hops) {
    for (const HopCounts::Bucket& bucket : hop.buckets) {
      text += fmt::format("{},{},{},{}\n", hop.name, bucket.lower_ns, bucket.upper_ns, bucket.count);
    }
  }
  return text;
}

Result<std::vector<HopCounts>> parse_latency_csv(std::string_view text, std::string_view name) {
  if (take_until(text, '\n') != kHeader) {
    return fail("{}:1: is not a latency table; its header must be {}", name, kHeader);
  }
  std::vector<HopCounts> hops;
  for (int line_number = 2; !text.empty(); ++line_number) {
    const std::string_view line = take_until(text, '\n');
    if (!line.empty() && !add_row(line, hops)) {
      return fail(
          "{}:{}: '{}' is not a row hop,lower_ns,upper_ns,count, or not in its place: the rows of a hop follow each other, ascending", name,
          line_number, line);
    }
  }
  std::erase_if(hops, [](const HopCounts& hop) { return hop.total() == 0; });
  if (hops.empty()) {
    return fail("{}: holds no durations; let the run last longer", name);
  }
  return hops;
}

Result<std::vector<HopCounts>> read_latency_csv(const std::filesystem::path& path) {
  const auto text = read_regular_file(path, "a run with --out writes it", kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_latency_csv(*text, path.string());
}

}  // namespace hapton
