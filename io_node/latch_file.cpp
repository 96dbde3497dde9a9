#include "io_node/latch_file.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <system_error>

#include "runtime/atomic_file.h"
#include "runtime/regular_file.h"
#include "runtime/state_folder.h"

namespace hapton {
namespace {

// The file has one word, the name of a fault.
constexpr std::size_t kMaxBytes = 64;

// Turns the text into a part of a file name that cannot lead to another folder.
std::string plain(std::string_view text) {
  std::string name(text);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '-'; }, '_');
  return name;
}

}  // namespace

SafetyFault LatchFile::read() const {
  if (file_.empty()) return SafetyFault::none;
  std::error_code missing;
  if (!std::filesystem::exists(file_, missing) && !missing) return SafetyFault::none;
  const auto text = read_regular_file(file_, "", kMaxBytes);
  for (int n = 1; n < kSafetyFaults; ++n) {
    const auto fault = static_cast<SafetyFault>(n);
    if (text && *text == std::string(to_string(fault)) + "\n") return fault;
  }
  return SafetyFault::position;
}

Result<void> LatchFile::keep(SafetyFault fault) const {
  if (file_.empty()) return {};
  return write_file_atomically(file_, std::string(to_string(fault)) + "\n", FileReaders::owner);
}

void LatchFile::forget() const {
  std::error_code ignored;
  if (!file_.empty()) std::filesystem::remove(file_, ignored);
}

std::filesystem::path find_latch_file(std::string_view device, std::string_view bind) {
  const std::filesystem::path folder = find_runtime_folder();
  // The name of a plug-in device is a path: its end is used. Reason for the limit: a file name has at most 255 bytes.
  constexpr std::size_t kLongest = 120;
  if (device.size() > kLongest) device.remove_prefix(device.size() - kLongest);
  return folder.empty() ? folder : folder / ("latched-" + plain(device) + "-" + plain(bind));
}

}  // namespace hapton
