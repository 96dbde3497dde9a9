#include "tools/dds/ros_names.h"

#include <algorithm>
#include <charconv>

namespace hapton::dds {
namespace {

constexpr std::size_t kLongestName = 200;  // a DDS topic may have 256 characters, and each topic here adds some to the prefix

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_word(std::string_view word) {
  if (word.empty() || !is_letter(word.front()) || word.find("__") != std::string_view::npos) return false;
  return std::all_of(word.begin(), word.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

// The start of the text with ? for special characters, so that an error with it has one line.
std::string printable(std::string_view text) {
  std::string shown(text.substr(0, 80));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return shown;
}

}  // namespace

Result<std::string> make_prefix(std::string_view prefix) {
  std::string_view remaining = prefix.starts_with('/') ? prefix.substr(1) : prefix;
  std::string checked_prefix;
  bool is_good = prefix.size() <= kLongestName;
  while (is_good) {
    const std::size_t slash = remaining.find('/');
    const std::string_view word = remaining.substr(0, slash);
    is_good = is_word(word);
    checked_prefix += "/" + std::string(word);
    if (slash == std::string_view::npos) break;
    remaining.remove_prefix(slash + 1);
  }
  if (is_good) return checked_prefix;
  return fail(
      "--prefix '{}' is not a name in ROS 2: give words of letters, digits and single underscores, none beginning with a digit, as in "
      "/hapton/left",
      printable(prefix));
}

std::string dds_topic(std::string_view ros_topic) { return "rt" + std::string(ros_topic); }

Result<void> check_frame(std::string_view frame) {
  const bool is_plain = std::all_of(frame.begin(), frame.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (is_plain && !frame.empty() && frame.size() <= kLongestName && !frame.starts_with('/')) return {};
  return fail("--frame '{}' is not a frame in ROS 2: give a name without blanks and without a slash at its beginning, as in world",
              printable(frame));
}

Result<void> check_interface(std::string_view interface) {
  const bool is_plain = std::all_of(interface.begin(), interface.end(), [](char c) {
    return is_letter(c) || is_digit(c) || c == '.' || c == ':' || c == '-' || c == '@' || c == '%';
  });
  if (is_plain && !interface.empty() && interface.size() <= kLongestName) return {};
  return fail("--interface '{}' is not a network interface: give a name or an address of `ip address`, as in eth0 or 192.168.1.5, or auto",
              printable(interface));
}

Result<int> choose_domain(std::optional<int> domain_option, const char* ros_domain_id) {
  if (domain_option) {
    if (*domain_option >= 0 && *domain_option <= kHighestDomain) return *domain_option;
    return fail("--domain {} does not exist: give 0 to {}", *domain_option, kHighestDomain);
  }
  const std::string_view text = ros_domain_id == nullptr ? "" : ros_domain_id;
  if (text.empty()) return 0;
  int domain = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error == std::errc() && end == text.data() + text.size() && domain >= 0 && domain <= kHighestDomain) return domain;
  return fail("ROS_DOMAIN_ID '{}' is not a domain: set it to a number from 0 to {}, or give --domain", printable(text), kHighestDomain);
}

}  // namespace hapton::dds
