#include "hid/hid_layout.h"

#include <algorithm>
#include <optional>

namespace hapton {
namespace {

// More bits than any report has: a descriptor that states more is broken.
constexpr std::size_t kMaxBits = std::size_t{1} << 19;
constexpr std::size_t kMaxNested = 64;

// An item's prefix without its size bits (HID 1.11, 6.2.2.2 to 6.2.2.8).
constexpr std::uint8_t kInput = 0x80;
constexpr std::uint8_t kOutput = 0x90;
constexpr std::uint8_t kCollection = 0xA0;
constexpr std::uint8_t kFeature = 0xB0;
constexpr std::uint8_t kEndCollection = 0xC0;
constexpr std::uint8_t kUsagePage = 0x04;
constexpr std::uint8_t kReportSize = 0x74;
constexpr std::uint8_t kReportId = 0x84;
constexpr std::uint8_t kReportCount = 0x94;
constexpr std::uint8_t kPush = 0xA4;
constexpr std::uint8_t kPop = 0xB4;
constexpr std::uint8_t kUsage = 0x08;
constexpr std::uint8_t kLongItem = 0xFE;
constexpr std::uint32_t kApplication = 0x01;

struct Globals {
  std::uint16_t page = 0;
  std::uint32_t size_bits = 0;
  std::uint32_t count = 0;
  std::uint8_t id = 0;
};

struct Bits {
  std::uint8_t id = 0;
  std::size_t input = 0;
  std::size_t output = 0;
  std::size_t feature = 0;
};

class Reader {
 public:
  // False: the descriptor is malformed at this item.
  bool take(std::uint8_t item, std::uint32_t value) {
    switch (item) {
      case kUsagePage:
        globals_.page = static_cast<std::uint16_t>(value);
        return true;
      case kReportSize:
        globals_.size_bits = value;
        return true;
      case kReportCount:
        globals_.count = value;
        return true;
      case kReportId:
        globals_.id = static_cast<std::uint8_t>(value);
        return value != 0 && value <= 0xFF;
      case kPush:
        global_stack_.push_back(globals_);
        return global_stack_.size() <= kMaxNested;
      case kPop:
        if (global_stack_.empty()) return false;
        globals_ = global_stack_.back();
        global_stack_.pop_back();
        return true;
      case kUsage:
        if (!usage_) usage_ = value;
        return true;
      default:
        return take_main(item, value);
    }
  }

  HidLayout finish() const {
    HidLayout layout{applications_, {}};
    for (const Bits& bits : bits_) layout.reports.push_back({bits.id, (bits.input + 7) / 8, (bits.output + 7) / 8, (bits.feature + 7) / 8});
    return layout;
  }

 private:
  bool take_main(std::uint8_t item, std::uint32_t value) {
    switch (item) {
      case kInput:
        return add(&Bits::input);
      case kOutput:
        return add(&Bits::output);
      case kFeature:
        return add(&Bits::feature);
      case kCollection:
        if (depth_++ == 0 && value == kApplication && usage_) applications_.push_back(compute_usage());
        return depth_ <= kMaxNested;  // usages of inner items are not needed: the end of the collection clears usage_
      case kEndCollection:
        usage_.reset();
        return depth_-- > 0;
      default:
        return true;  // limits, units, strings: not needed here
    }
  }

  bool add(std::size_t Bits::*kind) {
    usage_.reset();
    auto of_id = std::find_if(bits_.begin(), bits_.end(), [&](const Bits& bits) { return bits.id == globals_.id; });
    if (of_id == bits_.end()) of_id = bits_.insert(bits_.end(), Bits{globals_.id});
    const std::uint64_t more = std::uint64_t{globals_.size_bits} * globals_.count;
    if (more > kMaxBits || (*of_id).*kind + more > kMaxBits) return false;
    (*of_id).*kind += more;
    return true;
  }

  // A usage of four bytes has its page in the upper two.
  HidLayout::Usage compute_usage() const {
    const std::uint32_t usage = *usage_;
    return {usage > 0xFFFF ? static_cast<std::uint16_t>(usage >> 16) : globals_.page, static_cast<std::uint16_t>(usage)};
  }

  Globals globals_;
  std::vector<Globals> global_stack_;
  std::optional<std::uint32_t> usage_;
  std::size_t depth_ = 0;
  std::vector<HidLayout::Usage> applications_;
  std::vector<Bits> bits_;
};

}  // namespace

bool HidLayout::has_application(std::uint16_t page, std::uint16_t usage) const noexcept {
  return std::find(applications.begin(), applications.end(), Usage{page, usage}) != applications.end();
}

const HidLayout::Report* HidLayout::find_report(std::uint8_t id) const noexcept {
  const auto found = std::find_if(reports.begin(), reports.end(), [&](const Report& report) { return report.id == id; });
  return found == reports.end() ? nullptr : &*found;
}

HidLayout read_hid_layout(std::span<const std::uint8_t> descriptor) {
  Reader reader;
  while (!descriptor.empty()) {
    const std::uint8_t prefix = descriptor.front();
    descriptor = descriptor.subspan(1);
    if (prefix == kLongItem) {
      if (descriptor.size() < 2 || descriptor.size() - 2 < descriptor[0]) break;
      descriptor = descriptor.subspan(std::size_t{2} + descriptor[0]);
      continue;
    }
    const std::size_t size = (prefix & 3) == 3 ? 4 : prefix & 3;
    if (descriptor.size() < size) break;
    std::uint32_t value = 0;
    for (std::size_t byte = 0; byte < size; ++byte) value |= std::uint32_t{descriptor[byte]} << (8 * byte);
    descriptor = descriptor.subspan(size);
    if (!reader.take(prefix & 0xFC, value)) break;
  }
  return reader.finish();
}

}  // namespace hapton
